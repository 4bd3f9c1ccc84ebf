"""The numbers that decide in this room: each with its unit, and its reason."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

__all__ = ["TOL", "Tolerances"]


class Tolerances(NamedTuple):
    """Limits, steps and thresholds; a share or a factor where no unit is given."""

    # --- what is read ---------------------------------------------------------------------------------
    # Most that a record, or a scene beside it, may hold of anything [SI]. Up to the fourth power of it is
    # summed over the rows, which must stay far below the largest double, and nothing measured comes near it.
    largest: float = 1e20
    # Times by which a size is off, either way, before its unit is doubted: less than 10, as a sensitivity
    # that is wrong by 10 and a motion that is a little smaller than computed go together.
    far_off: float = 7.0
    looked_at: int = 300  # rows from which separator and header are found
    gap: float = 3.5  # usual steps of the time: in a longer one two rows may be missing, however rounded
    skipped: float = 0.05  # of the rows may hold no value
    cells_named: int = 5  # bad cells of a column, or rows, that a message names
    headers_named: int = 12  # headers that a message names

    # --- harmonic regression --------------------------------------------------------------------------
    # Relative: times are rounded when they are written. Cycles and samples may fall short of a whole number
    # by as much, or 40 samples a cycle would resolve 17 or 18 harmonics depending on the last digit.
    printed: float = 1e-6
    least_cycles: float = 2.0  # in the record, of any wave
    least_samples: int = 8  # in a drive cycle
    # The velocity of a slide has kinks, whose harmonics fall off quadratically: more of them add nothing.
    most_harmonics: int = 24
    of_nyquist: float = 0.9  # evenly spaced samples cannot resolve a harmonic at half their rate: stay below
    # Times the power that noise alone leaves in a harmonic; noise exceeds that in 3 of 10 000 harmonics.
    significant: float = 8.0

    # --- frequency of a record ------------------------------------------------------------------------
    coarsest: float = 4.0  # samples in a cycle of the largest wave
    explained_up_to: float = 8.0  # times the frequency of the largest wave
    padding: int = 4  # of the spectrum, so that its peaks lie within an eighth of 1/T
    near_peak: float = 0.6  # of 1/T: how far the best frequency may lie from the peak
    curvature_step: float = 0.02  # of 1/T: over it the end of the record turns by 3.6 deg
    lowest_fraction: int = 6  # the largest wave may be up to this harmonic
    rounded: float = 1e-6  # of a signal's largest value: less than that beside its trend is rounding
    # Of a power: a ridge that moves nothing, and the least that is left unexplained. Of the drive's own
    # motion: a residual counts as at least this. Relative, of a step: no shorter one is tried.
    rounding: float = 1e-12
    # Log-likelihood to be gained: 5 sigma, besides the logarithm of the number of frequencies tried.
    clear: float = 12.5
    own_wave: float = 0.1  # of the power of the largest wave: a lower one has it if that is its harmonic
    least_share: float = 0.3  # of a signal's power that must repeat, for a frequency to be claimed
    most_share: float = 0.8  # of it that is no noise,
    many_cycles: float = 5.0  # if it repeats for so many of them
    missing: float = 0.05  # of the power: with less, a wave counts as missing
    drifted: float = 0.05  # cycles by which drive and data may drift apart over the record
    sigmas: float = 4.0  # between two frequencies, or clocks: less is no difference
    most_cycles: int = 8  # of the drive, after which a body that hops may repeat its motion

    # --- alignment ------------------------------------------------------------------------------------
    shifts: int = 512  # in a cycle, that the search starts from
    # Of the signal: a misfit counts as at least this. One that fits exactly would outweigh all others.
    least_misfit: float = 1e-9
    # Spread of the log-likelihoods per sample below which all positions in the cycle fit equally well.
    flat: float = 1e-3
    # Long records are searched in part: errors are far below the sample time with so many rows,
    searched_rows: int = 6000
    searched_cycles: float = 4.0  # and at least so many cycles
    searched: float = 0.05  # of a cycle to each side of the rough result,
    searched_steps: int = 41  # in so many steps
    # Standard errors within which a wave is none, a line no ellipse, and a second position fits as well.
    likely_sigmas: float = 3.0

    # --- accelerations of the trough ------------------------------------------------------------------
    few_harmonics: float = 0.1  # of the fundamental's root mean square: less is told, and not warned of
    much_rest: float = 0.3  # of the same: what else may be left
    channel_phase: float = 2.0  # [deg] between two channels that is theirs, and no ellipse
    digits: int = 2  # below the first one of the error that are written
    usual_acceleration: float = 50.0  # [m/s^2] of a wave: hardly a conveyor vibrates with more
    # Of a motion: a component below it has no phase that would matter, and cannot be scaled up to all of it.
    least_component: float = 1e-3

    # --- comparison -----------------------------------------------------------------------------------
    slide_level: float = 0.1  # of a slide's computed peak speed: marks its start and end
    fine: int = 4096  # points a cycle at which folded signals are searched
    curve: int = 1001  # points of a smooth curve
    proposed: float = 0.01  # cycles by which a frequency that is proposed may drift from the data
    clocks_apart: float = 0.02  # of a cycle, between the clocks of trough and body: less is no difference
    inverted: float = 0.06  # of a cycle: as near to half of one

    # --- residuals of a fit ---------------------------------------------------------------------------
    jump_window: float = 0.25  # sample times over which the model's jumps are averaged: derivatives exist
    least_scale: float = 1e-3  # of the greatest value that is tried: a quantity counts as at least this large
    random_share: float = 0.1  # of a residual that must differ from cycle to cycle to tell of jitter
    variance_rounds: int = 3  # of weighting the squares that the variances are regressed on
    least_jitter_variance: float = 1e-3  # of the mean one
    jitter_gain: float = 6.0  # twice the log-likelihood: 2.4 sigma, for one more parameter
    most_tried: int = 20_000  # scenes of the first grid; of more a random part
    most_hopping: int = 40  # scenes with flights, each of which takes as long as a hundred others
    rough_shifts: int = 128  # in a cycle, that each of these is compared at
    starts: int = 3  # of a search, in each pattern
    at_once: int = 512  # scenes, in memory

    # --- Levenberg-Marquardt --------------------------------------------------------------------------
    # Relative, of derivatives: the model's noise is 1e-15, its curvature of order 1. Edges are as sharp.
    step: float = 1e-6
    edge_step: float = 1e-4  # the same along an edge, which is known less sharply
    idle: float = 1e-6  # of the largest effect of a coordinate: less is rounding, and counts as none
    dampings: tuple[float, ...] = (1e-12, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0)  # of the normalised equations
    light_dampings: tuple[float, ...] = tuple(np.geomspace(1e-7, 1e-2, 11).tolist())  # if accelerated
    accelerated: float = 10.0  # promised decrease [variances] above which geodesic acceleration pays
    acceleration_step: float = 0.1  # of a step, over which its acceleration is measured: h of the paper
    most_steps: int = 40
    fair: float = 0.3  # of the decrease that a whole step promises: with less, edges are looked for
    patience: float = 5.0  # steps as large as the last one that a search may still need
    edge_places: int = 65  # points between which an edge is looked for, in each round
    edge_rounds: int = 6  # at most
    distances: tuple[float, float, int] = (1e-7, 0.5, 60)  # relative, at which a pattern is looked for
    enough: float = 2e-3  # decrease of the sum of squares [variances] below which a search ends,
    rough: float = 1.0  # and a first one

    # --- fit ------------------------------------------------------------------------------------------
    confidence: float = 0.95
    # A pattern is excluded that fits worse by this [variances]: 4 sigma. The values of another pattern may
    # lie far away: excluding the true one at 2 sigma would be wrong by many half-widths once in 20 times.
    excluded: float = 16.0
    stands_out: float = 25.0  # [variances]: a motion must fit this much better than rest: 5 sigma
    explained: float = 1.5  # sum of squares over the number of samples [variances of the noise]
    better: float = 0.1  # of the threshold: a point this much better than the best is a new start,
    restarts: int = 3  # so often
    weighings: int = 3
    neighbours: int = 400  # points around a minimum at which other patterns are looked for,
    widest: float = 4.0  # standard deviations far,
    farthest_neighbour: float = 0.3  # and relatively so far in any case
    across: tuple[float, float, int] = (1e-5, 0.3, 40)  # relative distances beyond an edge, for the same
    kept: int = 24  # of both, of each pattern
    wide: float = 0.6  # of an estimate: a wider half interval leaves none: 30 % of standard error
    at_bound: float = 1e-3  # relative: an interval that reaches this near what is tried has no end
    close: float = 0.03  # of the threshold: the misfit at an end of an interval may miss it by this
    narrow: float = 0.02  # of the distance to the estimate: an end at an edge of a pattern is found to this
    first_step: float = 0.02  # relative, of an interval's search where the derivatives give none,
    most_step: float = 0.5  # and the greatest where they give one
    tries: int = 24  # points that are tried for one end
    apart: float = 0.02  # of the hull: intervals closer to each other than this are one
    unknown: float = 0.3  # relative standard error above which a combination counts as unknown
    group_share: float = 0.05  # of an unknown combination: a quantity with less is not part of it
    at_limit: float = 1e-4  # of the range of what is tried


TOL: Final = Tolerances()
