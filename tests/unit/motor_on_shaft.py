"""A shaft that a motor of another program drives, as a case file."""

SHAFT = """
schema = 1
title = "shaft"

[[bodies]]
name     = "shaft"
mass     = "2 kg"
inertia  = ["0.01 kg m^2", "0.01 kg m^2", "0.02 kg m^2"]
position = ["0 mm", "0 mm", "0 mm"]

[[joints]]
name     = "bearing"
kind     = "revolute"
between  = ["ground", "shaft"]
point    = ["0 mm", "0 mm", "0 mm"]
axis     = [0, 0, 1]
friction = { viscous = "0.02 N m s/rad" }

[[drives]]
name  = "shaft"
joint = "bearing"
speed = "300 rpm"
ramp  = "3000 rpm/s"

[run]
until = "20 ms"
"""
MOTOR = """
[[fmus]]
name  = "motor"
file  = "motor.fmu"
start = { U = 24.0 }

[[fmus.drives]]
drive  = "shaft"
torque = "M"
speed  = "w"
"""
