function cubic
  input Real x; input Real c[:,4]; output Real y;
protected
  Integer i; Real s;
algorithm
  i := integer(floor(x/0.1)) + 1; s := x - (i - 1)*0.1;
  y := ((c[i,1]*s + c[i,2])*s + c[i,3])*s + c[i,4];
end cubic;
model road
  parameter Real c[:,4] = {DATA};
  Real z(start=0, fixed=true), w(start=0, fixed=true);
  Real dz(start=0, fixed=true), dw(start=0, fixed=true), strut, tyre;
equation
  der(z) = dz; der(w) = dw;
  strut = 20e3*(z - w) + 1500*(dz - dw); tyre = 180e3*(w - cubic(15*time, c));
  300*der(dz) = -strut; 40*der(dw) = strut - tyre;
end road;
