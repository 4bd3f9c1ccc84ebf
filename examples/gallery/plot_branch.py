"""
A branch of hopping motions
===========================

A hopping motion, followed while the amplitude falls: the speed of each of its landings. From 8.5 mm down
a part lands at two speeds in turn; they meet at 8.23 mm, where the period doubles, and below it all
landings are alike. A solid line is stable: parts settle there. An unstable one would be dashed. There is
no command for this picture: ``vibro.follow`` is for those who study the dynamics.
"""

import math

import numpy as np

import vibro

scene = vibro.Scene(
    amplitude=8.5e-3,
    frequency=15,
    drive_angle=math.radians(30),
    static_friction=0.6,
    kinetic_friction=0.5,
)
branch = vibro.follow(scene, "amplitude", np.linspace(8.5e-3, 8e-3, 60))
figure = branch.draw("landing")
