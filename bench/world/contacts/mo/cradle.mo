model cradle
  parameter Real k=9.81/0.3, gap=1e-6;
  Real x1(start=-0.1, fixed=true), x2(start=0, fixed=true), x3(start=0, fixed=true),
    x4(start=0, fixed=true), x5(start=0, fixed=true);
  Real v1(start=0, fixed=true), v2(start=0, fixed=true), v3(start=0, fixed=true),
    v4(start=0, fixed=true), v5(start=0, fixed=true);
equation
  der(x1) = v1; der(x2) = v2; der(x3) = v3; der(x4) = v4; der(x5) = v5;
  der(v1) = -k*x1; der(v2) = -k*x2; der(v3) = -k*x3; der(v4) = -k*x4; der(v5) = -k*x5;
  when x2 - x1 + gap < 0 then
    reinit(v1, pre(v2)); reinit(v2, pre(v1));
  elsewhen x3 - x2 + gap < 0 then
    reinit(v2, pre(v3)); reinit(v3, pre(v2));
  elsewhen x4 - x3 + gap < 0 then
    reinit(v3, pre(v4)); reinit(v4, pre(v3));
  elsewhen x5 - x4 + gap < 0 then
    reinit(v4, pre(v5)); reinit(v5, pre(v4));
  end when;
end cradle;
