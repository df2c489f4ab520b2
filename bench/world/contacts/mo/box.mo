model box
  parameter Real over=0, mu=0.5, slope=atan(mu + over), g=9.81;
  Real x(start=0, fixed=true), v(start=4e-5, fixed=true);
  Boolean slips(start=true, fixed=true);
equation
  der(x) = v;
  der(v) = if slips then g*(sin(slope) - mu*cos(slope)) else 0;
  when v < 0 then
    slips = false;
    reinit(v, 0);
  end when;
end box;
