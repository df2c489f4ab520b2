model arm
  parameter Real m1=2, m2=1.5, l1=0.5, l2=0.4, g=9.81, T=0.01;
  parameter Real D=m2*l2^2, k=m2*l1*l2;
  Real a(start=-0.5, fixed=true), b(start=0.3, fixed=true);
  Real da(start=0, fixed=true), db(start=0, fixed=true), hand;
  discrete Real u1(start=0, fixed=true), u2(start=0, fixed=true), w1, w2;
  discrete Real s1(start=0, fixed=true), s2(start=0, fixed=true);
equation
  der(a) = da; der(b) = db; hand = m2*l2*g*sin(a + b);
  ((m1+m2)*l1^2 + D + 2*k*cos(b))*der(da) + (D + k*cos(b))*der(db)
    = u1 + k*sin(b)*(2*da + db)*db - (m1+m2)*l1*g*sin(a) - hand;
  (D + k*cos(b))*der(da) + D*der(db) = u2 - k*sin(b)*da^2 - hand;
  when sample(0, T) then
    w1 = 150*(1 - a) + 200*pre(s1) - 25*da;
    w2 = 90*(0.5 - b) + 120*pre(s2) - 12*db;
    u1 = max(-45, min(45, w1)); u2 = max(-20, min(20, w2));
    s1 = pre(s1) + (if abs(w1) < 45 then T*(1 - a) else 0);
    s2 = pre(s2) + (if abs(w2) < 20 then T*(0.5 - b) else 0);
  end when;
end arm;
