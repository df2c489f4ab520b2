model belt
  Real x(start=0, fixed=true), v(start=0.1, fixed=true);
  Boolean slips(start=false, fixed=true);
equation
  der(x) = v;
  der(v) = if slips then 1 - x else 0;
  when {x > 1.5, v > 0.1} then
    slips = x > 1.5;
    reinit(v, 0.1);
  end when;
end belt;
