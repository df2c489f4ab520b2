model graze
  parameter Real less=1e-6;
  Real x(start=0, fixed=true), v(start=1, fixed=true);
equation
  der(x) = v;
  der(v) = -x;
  when x > 1 - less then
    reinit(v, -0.5*pre(v));
  end when;
end graze;
