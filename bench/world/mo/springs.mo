model springs
  Real x(start=0.3, fixed=true), v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -(if x > 0 then 4 else 25)*x;
end springs;
