"""Solvers written apart from the package, with which the tests compare it. None of them imports vibro.

Each takes the dimensionless groups of a body, or a few numbers. Where an annotation names
``helpers.scenes.Groups``, the fields of that record alone are read.

event_walk
    Steady cycle in contact of a drive along a line: slide after slide; each end is a zero of the closed-form
    speed, by Brent's method in a bracket that holds one alone. Shares nothing.
two_axis_walk
    Motion, flights and bounces included, of a drive along two axes: event after event; closed forms between
    them, and Brent's method between two zeros of the derivative. Shares nothing.
harmonic_walk
    Steady cycle in contact of a drive with harmonics: slide after slide; Newton's law integrated in closed
    form, zeros bracketed on a fine mesh and found by Brent's method. Shares nothing.
step_walk
    Steady cycle in contact of a trough whose acceleration is constant on steps: one uniform acceleration of
    the body after the other. Shares nothing.
harmonic_flight
    Motion, flights included, of a drive with harmonics, at restitution 0: event after event; closed forms
    between them, zeros bracketed on a mesh and found by Brent's method. Shares nothing.
integrated
    Motion, flights and bounces included, of a drive along a line or an ellipse: ``scipy.integrate.solve_ivp``
    with an event for every change, no closed form. Shares nothing.
two_way
    A vibrating machine and a body on it that act on each other, or a body alone on a trough that moves as
    prescribed: event after event, matrix exponentials between them. Shares nothing.
"""
