"""Experiment files: what is walked by which robot, on which ground, how often.

Here belong the file with the place of every mistake, the Experiment, the study's section and the
Plan; nothing here simulates, searches or writes a page. SI units and radians throughout. Keys:

    name: eros_table7               name of the results; by default the file's
    title, description              text
    include: bases/eros.yaml        a base file; where both have a value this file wins, and a
                                    key with nothing after it leaves out the base's
    robot: eros                     a name, a file (./my_robot.py), or {type: eros, mass: 3.5}
    gait: {type: eros, step_height: 0.03}
    walkers:                        several robots, instead of robot: and gait:
      - {robot: nao, gait: nao}         each may have servo:, engine: and a name:
      - {include: bases/bioloid.yaml}   robot, gait, servo, engine of a base file
    balance: {type: ankle_hip, ankle_pitch_gain: 0.3}   closes the loop; by default none
    metrics: [./my_metric.py]       files of one's own metrics; reports and searches know them
    depends: [./lift.csv, ./tables] what code of one's own reads where nobody sees it read
    surfaces: [grass_50mm, ./our_field.yaml]
    surface: {toe_catch: 5.0}       set on every surface, which must have the parameter
    servo: {type: mx_28, supply: 11.1}   set on every servo; `type` replaces the robot's choice
    grid:                           every combination of
      gait.step_length: [0.0, 0.02]     lists under dotted paths that start with gait., surface.,
      robot.sole.kind: [flat, studs]    balance., servo., robot., engine., horizon.,
      push.impulse: [0.5, 1.0]          spread., slope. or push.
      balance.type: [none, ankle_hip]   without and with the controller of `balance:`
    zip:                            lists that move together; several such mappings as a list
      gait.heel_strike: [none, add]
      gait.landing_deceleration: [none, log_tail]
    one_at_a_time:                  the base, then each path varied alone
      gait.step_height: [0.02, 0.03, 0.04]
    design:                         points that fill a box: a sweep of many parameters at once,
      {type: sobol, points: 64, ...}  see `gaitlab.experiment.design`
    study:                          parameters that are searched, instead of varied: a file for
      {...}                           `gaitlab optimize`, see `gaitlab.experiment.study_reading`
    seeds: 10                       seeds 0 to 9, or a list of seeds
    horizon: {cycles: 9, distance: 6.0, time: 60.0}     whichever comes first
    engine: {dt: 0.002}
    spread: {friction: 0.1}         how much the replicates differ
    slope: {pitch: 3}               degrees by which the ground rises ahead; roll: to the left
    push: {impulse: 1.0, direction: 90, cycle: 3, instant: 0.25}    N s, degrees to the left
    log: {every: 1}
    report: {rows: gait.step_length, columns: surface, variants: [...], compare: eros_table7,
             distance_reading: foot_travel, title: text,
             metrics: [walking_speed, ...],     drawn for each surface; by default six
             maps: [[gait.step_length, gait.step_height], ...]}     stable share over two paths

A number may carry its origin: {value: 0.03, unit: m, source: "our paper"}.
"""

from gaitlab.experiment.axes import Axis, combinations
from gaitlab.experiment.design import Design, Follower, SweptRange
from gaitlab.experiment.experiment import (
    Experiment,
    candidate,
    form_of,
    in_form,
    refuse_study,
    study_of,
)
from gaitlab.experiment.loading import is_reproduction, load_experiment, studies
from gaitlab.experiment.parts import NO_BALANCE, Parts, Value, changed, changes_of, owned, try_out
from gaitlab.experiment.schema import ReportSettings
from gaitlab.experiment.study import Study

__all__ = [
    "NO_BALANCE",
    "Axis",
    "Design",
    "Experiment",
    "Follower",
    "Parts",
    "ReportSettings",
    "Study",
    "SweptRange",
    "Value",
    "candidate",
    "changed",
    "changes_of",
    "combinations",
    "form_of",
    "in_form",
    "is_reproduction",
    "load_experiment",
    "owned",
    "refuse_study",
    "studies",
    "study_of",
    "try_out",
]
