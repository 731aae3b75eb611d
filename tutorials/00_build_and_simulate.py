# %% [markdown]
# # Build and simulate
#
# A *skill* is a navigation field learned from a carer's strokes, or a chain of them
# (tutorial 03). A *scenario* says who is washed, where the camera and the arm stand,
# and what the run is judged by. Out of both comes one Drake Diagram: camera,
# perception, controller, arm. Here we build it, run it for a few seconds of simulated
# time and look at what it did.

# %%
import matplotlib.pyplot as plt
import numpy as np

from bath_drake.control.approach import Phase
from bath_drake.diagrams import build_reproduction
from bath_drake.diagrams.block_diagram import wiring_lines
from bath_drake.field.navigation import phi
from bath_drake.scenario import find_skill, load_scenario
from bath_drake.simulation import run
from bath_drake.skill_file import load_skill
from bath_drake.verification import evaluate

# %% [markdown]
# Scenarios and skills are YAML files; a bare name means a shipped one. Every value
# that the file leaves out has a default, and each can be set from Python too. The
# whole stroke takes some 15 s; we stop earlier.

# %%
scenario = load_scenario("reproduction")
scenario.duration = 9.0  # s
skill = load_skill(find_skill(scenario.skill))

# %% [markdown]
# ## The Diagram
#
# Every system has a name, so that the wiring can be read. The true pose of the body,
# `patient_motion.body_pose`, goes into the log and nowhere else: the loop knows the
# person through the camera's two images alone.

# %%
diagram = build_reproduction(scenario, skill)
for line in wiring_lines(diagram):
    if line.startswith(("camera", "patient_motion", "navigation_controller")):
        print(line)

# %% [markdown]
# ## The run
#
# `run` advances a Simulator until the loop monitor ends the run (at the goal, on
# time-out, or too close to the skin) and returns the log: arrays of what was
# commanded, seen and true.

# %%
log = run(diagram, scenario)
washing = log.phase == Phase.WASH
print(f"{log.outcome} after {log.time[-1]:.1f} s, {log.frames} frames")
print(f"washed for {np.ptp(log.time[washing]):.1f} s")

# %% [markdown]
# ## The verdict
#
# The verification knows the person's own mesh. As we stopped early, the goal was not
# reached and the path is not whole; the nozzle's errors are those of a full run.

# %%
evaluation = evaluate(log, scenario, skill)
for name, check in evaluation.metrics["checks"].items():
    print(f"{'pass' if check['pass'] else 'FAIL'}  {name}: {check['value']}")

# %% [markdown]
# ## The path
#
# In canonical space the back is the square from -1 to 1, x to the person's right, y
# to the head. The field's level curves lead from the start to the goal; the executed
# path (through the camera's eyes and over a breathing, twisting back) follows the
# roll-out, which needs no simulator at all.

# %%
x, y = np.meshgrid(np.linspace(-1.0, 1.0, 161), np.linspace(-1.0, 1.0, 161))
levels = phi(np.stack([x, y], axis=-1), skill.field)
figure, axes = plt.subplots(figsize=(6.0, 5.5), layout="constrained")
axes.contour(x, y, levels, levels=np.linspace(0.0, 1.0, 25)[1:-1], linewidths=0.6)
axes.plot(*evaluation.mean_demonstration.T, "k--", label="mean demonstration")
axes.plot(*evaluation.rollout.T, label="roll-out")
axes.plot(*evaluation.executed.T, linewidth=3.0, alpha=0.7, label="executed")
axes.plot(*skill.field.goal, "k*", markersize=12, label="goal")
axes.set(xlabel="x", ylabel="y", aspect="equal", title="Canonical space")
axes.legend(loc="lower left")
plt.show()

# %% [markdown]
# And the distance of the nozzle to the true skin, less the stand-off it should keep.

# %%
figure, axes = plt.subplots(figsize=(6.0, 2.5), layout="constrained")
axes.plot(evaluation.time, evaluation.surface_error_mm)
axes.axhline(0.0, color="0.5", linewidth=0.8)
axes.set(xlabel="time (s)", ylabel="error (mm)")
plt.show()

# %% [markdown]
# From here: `bath-drake simulate reproduction --person f_thin` runs the whole stroke
# on somebody else and writes a report; `bath-drake learn` makes a skill out of your
# own recordings.
