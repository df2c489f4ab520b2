connector Flange
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
