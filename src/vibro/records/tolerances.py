"""Limits, steps and thresholds of the analysis of records, each with its unit and reason."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np


class Tolerances(NamedTuple):
    """Limits, steps and thresholds; shares or factors if no unit is given."""

    # --- reading --------------------------------------------------------------------------------------
    # Largest value in a record, or in a scene that is compared with one [SI]; the smallest in a scene is its
    # inverse. Fourth powers are summed over the rows and must stay far below the largest double.
    largest: float = 1e20
    # Ratio of measured and computed size, either way, from which a unit is doubted: less than 10, as a
    # sensitivity may be wrong by 10 and the motion a little smaller than computed.
    far_off: float = 7.0
    far_angle: float = float(np.radians(20.0))  # [rad] from the scene's drive angle: sensors may be exchanged
    looked_at: int = 300  # rows in which separator and header are searched
    gap: float = 3.5  # usual steps of the time in one step: two missing rows and the rounding of times
    skipped: float = 0.05  # largest share of rows without a value
    cells_named: int = 5  # bad cells of a column, or rows, that a message names
    headers_named: int = 12  # headers that a message names

    # --- harmonic regression --------------------------------------------------------------------------
    # Relative: times are rounded when they are written. Cycles and samples may fall short of a whole number
    # by as much, or 40 samples a cycle would resolve 17 or 18 harmonics depending on the last digit.
    printed: float = 1e-6
    least_cycles: float = 2.0  # cycles of any wave in the record
    least_samples: int = 8  # samples a drive cycle
    # The velocity of a slide has kinks, whose harmonics fall off quadratically: more of them do not help.
    most_harmonics: int = 24
    of_nyquist: float = 0.9  # of half the sampling rate, at which a harmonic cannot be resolved
    # Power of a harmonic over the mean power of noise in it; noise exceeds this in 3 of 10 000 harmonics.
    significant: float = 8.0

    # --- frequency of a record ------------------------------------------------------------------------
    coarsest: float = 4.0  # samples in a cycle of the largest wave
    explained_up_to: float = 8.0  # highest harmonic over the frequency of the largest wave
    padding: int = 4  # of the spectrum, so that its peaks lie within an eighth of 1/T
    near_peak: float = 0.6  # [1/T] largest distance of the best frequency from the peak
    curvature_step: float = 0.02  # [1/T] the phase at the end of the record changes by 3.6 deg
    lowest_fraction: int = 6  # highest harmonic that may be the largest wave
    rounded: float = 1e-6  # of a signal's largest value: smaller deviations from its trend are rounding
    # Of a power: the ridge of a regression, and the least residual. Of the amplitude of the drive: the least
    # standard deviation of a residual. Of a quantity: the least step.
    rounding: float = 1e-12
    # Gain of the log-likelihood: 5 sigma, besides the logarithm of the number of frequencies that are tried.
    clear: float = 12.5
    own_wave: float = 0.1  # least power of a fundamental over that of the largest wave
    least_share: float = 0.3  # of a signal's power that a frequency must explain
    most_share: float = 0.8  # of a signal's power: noise explains less,
    many_cycles: float = 5.0  # if there are so many cycles
    missing: float = 0.05  # of the power: a wave with less counts as missing
    drifted: float = 0.05  # cycles by which drive and data may drift apart over the record
    sigmas: float = 4.0  # standard errors by which two frequencies, or clocks, differ at least
    most_cycles: int = 8  # drive cycles after which a body that hops may repeat its motion

    # --- alignment ------------------------------------------------------------------------------------
    shifts: int = 512  # shifts in a cycle at which the search begins
    # Least misfit of a signal over its size. A signal that fits exactly would outweigh all others.
    least_misfit: float = 1e-9
    # Range of the log-likelihoods per sample below which all positions in the cycle fit equally well.
    flat: float = 1e-3
    # Only the middle of long records is searched: errors are far below the sample time with so many rows,
    searched_rows: int = 6000
    searched_cycles: float = 4.0  # and at least so many cycles
    searched: float = 0.05  # [cycles] to each side of the rough result,
    searched_steps: int = 41  # in so many steps
    # Standard errors above which a wave stands out, an ellipse is no line, and a rival position does not fit.
    likely_sigmas: float = 3.0

    # --- accelerations of the trough ------------------------------------------------------------------
    few_harmonics: float = 0.1  # root mean square of harmonics over the fundamental's: warn of more
    much_rest: float = 0.3  # the same of the residual
    channel_phase: float = 2.0  # [deg] phase that two channels may add, so that a line seems an ellipse
    digits: int = 2  # digits that are written below the first one of the error
    usual_acceleration: float = 50.0  # [m/s^2] conveyors hardly vibrate with more
    # Of a motion: the phase of a smaller component does not matter, and the motion cannot be scaled from it.
    least_component: float = 1e-3

    # --- harmonics of the trough's motion -------------------------------------------------------------
    motion_harmonics: int = 16  # that are tested
    of_sampling: float = 0.45  # of the sampling rate: the highest of them, with the band beside it
    band: float = 0.35  # of the drive's frequency, to each side of a harmonic: noise there is that in it
    # Two bins to each side of a harmonic, of which two channels need more than one for their covariance.
    motion_cycles: float = 6.0
    about: float = 1e-3  # by which cycles and samples may fall short, as the frequency is measured
    usual_samples: float = 40.0  # a cycle, which show 16 harmonics
    by_chance: float = 1e-3  # probability by which noise passes for a harmonic
    frequency_rows: int = 40_000  # in the middle of a record in which its frequency is searched,
    frequency_growth: int = 4  # and growth of that part from one refinement to the next
    frequency_rounds: int = 8  # of Gauss and Newton's method; two are usual,
    frequency_step: float = 0.1  # [1/T] largest step of it, as the first frequency is better
    frequency_close: float = 1e-7  # of that step: the last one
    clip_band: float = 0.002  # of a signal's range, beside its ends
    # Rows at an end over those in the band: 2.4 of a sine of whole digits, 5.3 of a flatter crest.
    clip_ratio: float = 8.0

    harmonics_matter: float = 1e-3  # of the speed: a smaller change by harmonics is left out of a comparison
    draws: int = 200  # of the noise: their standard deviation is known to 5 %
    gain: float = 0.02  # usual errors of calibration: of a sensitivity,
    tilt: float = float(np.radians(1.0))  # [rad] of the way that sensors are put on,
    delay: float = 50e-6  # [s] and of the time between two channels

    # --- comparison -----------------------------------------------------------------------------------
    slide_level: float = 0.1  # of a slide's computed peak speed, at its start and end
    fine: int = 4096  # points a cycle at which folded signals are searched
    curve: int = 1001  # points of a smooth curve
    proposed: float = 0.01  # [cycles] drift of a proposed frequency from the data over the record
    # Of what the given frame leaves: less, and the other one is likely. Wrong friction makes it 0.3.
    other_frame_gain: float = 0.25
    # Of the trough's motion: what may be left in the other frame then, of the computed motion
    other_frame_left: float = 0.3
    # and of a part at rest, as a part with little friction that slides moves much like the trough.
    rest_left: float = 0.1
    clocks_apart: float = 0.02  # [cycles] least difference of the clocks of trough and body to warn of
    inverted: float = 0.06  # [cycles] distance of that from half a cycle if a sensor is inverted

    # --- residuals of a fit ---------------------------------------------------------------------------
    jump_window: float = 0.25  # sample times over which the model's jumps are averaged: derivatives exist
    least_scale: float = 1e-3  # of the greatest value that is tried: least size of a quantity
    most_predecessors: int = 8  # samples on which the noise of one may depend,
    rows_of_a_predecessor: int = 30  # and rows for each of them
    random_share: float = 0.1  # of the power of a residual that must change from cycle to cycle, for jitter
    variance_rounds: int = 3  # regressions of the variances, each weighted by the last one
    least_jitter_variance: float = 1e-3  # of the mean variance
    jitter_gain: float = 6.0  # twice the gain of log-likelihood: 2.4 sigma, for one more parameter
    most_tried: int = 20_000  # scenes of the first grid; a random part of a larger one
    most_hopping: int = 40  # scenes with flights, each of which takes as long as a hundred others
    rough_shifts: int = 128  # shifts in a cycle at which each of these is compared
    starts: int = 3  # starts of the search in each pattern
    at_once: int = 512  # scenes in memory

    # --- Levenberg-Marquardt --------------------------------------------------------------------------
    # Relative step of derivatives: the model's noise is 1e-15, its curvature of order 1. It is also the error
    # of edges.
    step: float = 1e-6
    edge_step: float = 1e-4  # the same along an edge, whose position has the error above
    idle: float = 1e-6  # of the largest effect of a coordinate: less is rounding, and becomes 0
    dampings: tuple[float, ...] = (1e-12, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0)  # of the normalised equations
    light_dampings: tuple[float, ...] = tuple(np.geomspace(1e-7, 1e-2, 11).tolist())  # if accelerated
    accelerated: float = 10.0  # [variances] predicted decrease above which geodesic acceleration pays
    acceleration_step: float = 0.1  # of a step, for its second derivative: h of the paper
    most_steps: int = 40
    fair: float = 0.3  # of the decrease that a whole step predicts: after less, edges are searched
    patience: float = 5.0  # steps with the decrease of the last one in which a search must reach its aim
    edge_places: int = 65  # points between which an edge is searched, in each round
    edge_rounds: int = 6  # largest number of rounds
    distances: tuple[float, float, int] = (1e-7, 0.5, 60)  # relative, at which a pattern is searched
    enough: float = 2e-3  # [variances] decrease of the sum of squares below which a search ends,
    rough: float = 1.0  # and a first one

    # --- fit ------------------------------------------------------------------------------------------
    confidence: float = 0.95
    # [variances] A pattern that fits worse by this is excluded: 4 sigma. Another pattern may have values far
    # away: excluding the true one at 2 sigma would be wrong by many half-widths once in 20 times.
    excluded: float = 16.0
    stands_out: float = 25.0  # [variances] by which a motion must fit better than rest: 5 sigma
    explained: float = 1.1  # largest sum of squares over the number of samples of an explained record
    better: float = 0.1  # of the threshold: a point better than the best by this starts another search,
    restarts: int = 3  # so often
    settled_errors: float = 0.1  # [standard errors of a drive] by which another weighing may move them,
    weighings: int = 3  # and how often that and the weights are found anew
    neighbours: int = 400  # points around a minimum at which other patterns are searched,
    widest: float = 4.0  # up to so many standard deviations,
    farthest_neighbour: float = 0.3  # and up to this relative distance
    across: tuple[float, float, int] = (1e-5, 0.3, 40)  # relative distances beyond an edge, for the same
    kept: int = 24  # points of each of both that are kept for a pattern
    wide: float = 0.6  # half an interval over its estimate, at most: 30 % of standard error
    at_bound: float = 1e-3  # relative distance from a bound of the search at which an interval has no end
    close: float = 0.03  # of the threshold: error of the misfit at an end of an interval
    narrow: float = 0.02  # of the distance to the estimate: error of an end at an edge of a pattern
    first_step: float = 0.02  # relative, to the end of an interval, if the derivatives give none,
    most_step: float = 0.5  # and the greatest if they give one
    tries: int = 24  # points that are tried for one end
    apart: float = 0.02  # of the hull: intervals closer to each other are united
    unknown: float = 0.3  # relative standard error above which a combination is unknown
    group_share: float = 0.05  # of an unknown combination: a quantity with less is not part of it
    at_limit: float = 1e-4  # of the range that is tried: distance of an estimate at its limit


TOL: Final = Tolerances()
