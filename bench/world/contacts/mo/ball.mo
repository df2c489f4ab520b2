model ball
  Real y(start=0, fixed=true), v(start=5, fixed=true);
  Boolean rests(start=false, fixed=true);
equation
  der(y) = if rests then 0 else v;
  der(v) = if rests then 0 else -9.81;
  when y < 0 then
    rests = pre(rests) or -pre(v) < 1e-9;
    reinit(v, if rests then 0 else -0.8*pre(v));
  end when;
end ball;
