"""Modelica, by the compiler Rumoca and its own solvers; there is no standard library beside it."""

from __future__ import annotations

import rumoca
from scipy.interpolate import CubicSpline

from .cases import UNTIL, road

VERSION = f"Rumoca {rumoca.version()}"
WIND = """model wind
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
"""
SPRINGS = """model springs
  Real x(start=0.3, fixed=true), v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -(if x > 0 then 4 else 25)*x;
end springs;
"""
ROAD = """function cubic
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
"""
ARM = """model arm
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
"""
MOTORS = """connector Flange
  Real phi; flow Real tau;
end Flange;
model Motor
  parameter Real J=0.02, K=0.3, R=1.5, b=0.01, u=0;
  Flange shaft; Real w, i;
equation
  der(shaft.phi) = w; i = (u - K*w)/R;
  J*der(w) = K*i - b*w + shaft.tau;
end Motor;
model Gear
  parameter Real n=3; Flange fast, slow;
equation
  fast.phi = n*slow.phi; slow.tau = -n*fast.tau;
end Gear;
model motors
  Motor left(u=12, w(start=3, fixed=true)), right(J=0.3, R=4);
  Gear gear;
equation
  connect(left.shaft, gear.fast); connect(right.shaft, gear.slow);
initial equation
  left.shaft.phi = 0;
end motors;
"""
TEXTS = {"wind": WIND, "springs": SPRINGS, "road": ROAD, "arm": ARM, "motors": MOTORS}
STATES = {
    "wind": ("hip", "knee", "dhip", "dknee"),
    "springs": ("x", "v"),
    "road": ("z", "w", "dz", "dw"),
    "arm": ("a", "b", "da", "db"),
    "motors": ("left.shaft.phi", "right.shaft.phi", "left.w", "right.w"),
}


def _prepared(name: str):
    def prepare(way: str):
        text = TEXTS[name]
        if name == "road":
            rows = CubicSpline(*road()).c.T.tolist()
            data = ", ".join("{" + ", ".join(map(repr, row)) + "}" for row in rows)
            text = text.replace("DATA", data)
        model = rumoca.Session().loads(text, model=name)
        tight = rumoca.SimConfig(solver="rk-like", rtol=1e-12, atol=1e-14)
        config = {} if way == "default" else {"config": tight}

        def go():
            found = model.simulate(t=(0, UNTIL[name]), dt=UNTIL[name], **config)
            return [found[x][-1] for x in STATES[name]]

        return go

    return prepare


MODELS = {name: _prepared(name) for name in TEXTS}
WAYS = dict.fromkeys(TEXTS, ("default", "best"))
COUNTED = {name: (text,) for name, text in TEXTS.items()}
SAYS = {
    "wind": ("equations by hand", "–"),
    "springs": ("if", "located by itself"),
    "road": ("function with the data in the text", "?"),
    "arm": ("when sample", "stops at samples by itself"),
    "motors": ("two components, connect", "–"),
}
