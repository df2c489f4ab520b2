model wind
  parameter Real m1=1, m2=0.5, l1=1, l2=0.8, a1=0.5, a2=0.4, I1=0.09, I2=0.03;
  parameter Real g=9.81, c=0.2, w=4;
  parameter Real A=m1*a1^2+I1+m2*l1^2, B=m2*l1*a2, D=m2*a2^2+I2;
  Real hip(start=1.2, fixed=true), knee(start=-0.5, fixed=true);
  Real dhip(start=0, fixed=true), dknee(start=0, fixed=true);
  Real p, q, dp, dq, fx, fz;
equation
  der(hip) = dhip; der(knee) = dknee;
  p = hip; q = hip+knee; dp = dhip; dq = dhip+dknee;
  fx = c*(w - l1*cos(p)*dp - l2*cos(q)*dq);
  fz = -c*(l1*sin(p)*dp + l2*sin(q)*dq);
  A*der(dhip) + B*cos(p-q)*(der(dhip)+der(dknee)) + B*sin(p-q)*dq^2 + (m1*a1+m2*l1)*g*sin(p)
    = l1*(fx*cos(p) + fz*sin(p));
  B*cos(p-q)*der(dhip) + D*(der(dhip)+der(dknee)) - B*sin(p-q)*dp^2 + m2*a2*g*sin(q)
    = l2*(fx*cos(q) + fz*sin(q));
end wind;
