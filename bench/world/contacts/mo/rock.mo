model rock
  Real a(start=0.1, fixed=true), w(start=0, fixed=true);
  Boolean rests(start=false, fixed=true);
equation
  der(a) = w;
  der(w) = if rests then 0 else -0.75*9.81*(if a > 0 then sin(0.2 - a) else -sin(0.2 + a));
  when {a < 0, a > 0} then
    rests = pre(rests) or abs(pre(w)) < 1e-9;
    reinit(w, if rests then 0 else (1 - 1.5*sin(0.2)^2)*pre(w));
  end when;
end rock;
