# %% [markdown]
# # From a depth camera's recording to a wash with circles
#
# The whole way of a carer's stroke: a folder of colour and depth images, as any RGB-D
# camera writes it; the stroke in the frame of the back, which moves; what of it is a
# slow motion and what goes round and round; a field for the one and a limit cycle for
# the other; and the robot that washes both on another person's back.
#
# Nobody was filmed for this. The simulated camera films a simulated carer, with a
# Kinect's noise, and writes such a folder; what is true of it is used to judge, never
# to capture.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from bath_drake.carer.config import RubbingConfig
from bath_drake.carer_recording import record_carer
from bath_drake.control.approach import Phase
from bath_drake.demonstrations.capture.demonstration import demonstration
from bath_drake.demonstrations.capture.options import CaptureOptions
from bath_drake.demonstrations.capture.pipeline import capture
from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.rgbd.folder import open_rgbd
from bath_drake.diagrams import build_reproduction
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.learner import learn_skill
from bath_drake.learning.periodic import learn_cycle
from bath_drake.report.capture_figure import draw_capture
from bath_drake.report.cycle_figure import draw_cycle
from bath_drake.scenario import load_scenario
from bath_drake.scene.sensing import begin_recording
from bath_drake.simulation import run
from bath_drake.skill_file import skill_from_result
from bath_drake.verification import evaluate

# %% [markdown]
# ## A recording
#
# The same as `bath-drake simulate demonstration --record FOLDER`, but shorter and at 10
# frames a second, so that you need not wait. A folder of your own has the same layout:
# `color/`, `depth/`, `intrinsics.json`, `timestamps.csv` (docs/rgbd.md).

# %%
scenario = load_scenario("demonstration")
carer = scenario.scene.carer
carer.demonstration = None
carer.waypoints = [[-0.45, 0.5], [-0.1, 0.4], [0.1, -0.1], [0.45, -0.4]]
carer.seconds, carer.pause = 9.0, 0.2
carer.rubbing = RubbingConfig(kind="circles", amplitude=0.12, frequency=1.1)
scenario.perception.camera_rate = 10.0

folder = tempfile.TemporaryDirectory()
film = Path(folder.name) / "film"
truth = record_carer(begin_recording(film, scenario.scene.camera), scenario)
recording = open_rgbd(film)
print(f"{len(recording)} frames; the marker is to be seen in {truth.seen}")

# %% [markdown]
# ## The stroke in it
#
# `bath-drake capture FOLDER -o DEMO.csv` in Python. The back is followed from frame to
# frame, with a box that is the same in all of them; the marker is found as the one
# small vivid blob that is no skin, and laid onto the skin below it.

# %%
found = capture(recording, CaptureOptions())
stroke = demonstration(found, Path("captured.csv"), film)
(shown,), frame = canonical_demonstrations([stroke])
draw_capture(recording, found, shown)

# %% [markdown]
# How far is it from the truth? Most of the distance is one shift of everything: the
# camera and the mesh do not agree on where a back ends, and so on where its middle is.

# %%
p_N = np.array(truth.p_N)
side = np.ptp(p_N, axis=0).max()
shift = (
    shown.raw - np.stack([np.interp(found.stroke.t, truth.t, c) for c in p_N.T], 1)
).mean(0)
print(f"Fréchet distance to the truth: {discrete_frechet(shown.raw, p_N) / side:.4f}")
print(f"without the shift: {discrete_frechet(shown.raw - shift, p_N) / side:.4f}")

# %% [markdown]
# ## Taken apart
#
# The circles stand out of the slow motion: the data tell their period and their size.

# %%
part = shown.periodic
slow = np.array(truth.discrete_N)
print(f"period {part.period:.3f} s; it was {1.0 / carer.rubbing.frequency:.3f} s")
print(
    "discrete part, Fréchet distance to the truth: "
    f"{discrete_frechet(shown.points, slow) / np.ptp(slow, axis=0).max():.4f}"
)
fig, axes = plt.subplots(figsize=(6, 6))
axes.plot(*shown.raw.T, lw=1, label="captured")
axes.plot(*shown.points.T, lw=2.5, label="its discrete part")
axes.plot(*slow.T, "k--", lw=1, label="true discrete part")
axes.set(
    xlabel="x in N", ylabel="y in N", aspect="equal", title="One stroke, two motions"
)
axes.legend()
plt.show()

# %% [markdown]
# ## Learned
#
# The discrete part becomes a field with virtual obstacles, certified as any other; the
# circles become a limit cycle. `bath-drake learn` does both and writes one skill file.

# %%
result = learn_skill([shown], LearnerConfig.quick())
periodic = learn_cycle([shown])
skill = skill_from_result(result, [shown], frame, periodic.cycle)
print(f"converged {result.converged}, {skill.certificate['verdict']}")
cycle = skill.periodic
print(f"a circle of radius {cycle.radius:.3f} every {cycle.pitch:.3f} of the way")

# %% [markdown]
# ## Washed
#
# On another person, who breathes and twists, the robot washes along the field with the
# circles on top. Both parts slow down together where their sum would be faster along
# the skin than 7 cm/s. We stop after 14 s; `bath-drake simulate scrubbing` goes all the
# way.

# %%
wash = load_scenario("reproduction")
wash.scene.person = "f_avg"
wash.duration = 14.0
log = run(build_reproduction(wash, skill), wash)
evaluation = evaluate(log, wash, skill)
print(evaluation.metrics["periodic"])

washing = log.phase == Phase.WASH
fig, axes = plt.subplots(figsize=(6, 6))
axes.plot(*shown.points.T, lw=1, color="0.6", label="shown, discrete part")
axes.plot(*log.canonical_reference[washing].T, "k--", lw=1, label="reference")
axes.plot(*evaluation.executed.T, lw=1.6, color="#d7301f", label="washed on the skin")
axes.set(xlabel="x in N", ylabel="y in N", aspect="equal", title="Washed, after 14 s")
axes.legend()
plt.show()

# %%
draw_cycle(cycle, [shown], evaluation.offsets, evaluation.around)

# %%
assert discrete_frechet(shown.raw, p_N) / side < 0.06
assert discrete_frechet(shown.raw - shift, p_N) / side < 0.02
assert abs(part.period * carer.rubbing.frequency - 1.0) < 0.03
assert result.converged
assert evaluation.metrics["periodic"]["gain"] > 0.8
folder.cleanup()
