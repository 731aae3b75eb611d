# %% [markdown]
# # Another arm
#
# The arm is the scenario's choice: a model's file, where it stands, and two postures.
# This takes the KUKA LBR iiwa 14 that ships as if it were an arm of one's own, looks
# at what is read out of its file, asks whether it gets all over a back, and has it
# wash.

# %%
import shutil
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from bath_drake.diagrams import build_reproduction
from bath_drake.reach.precheck import reachability
from bath_drake.resources import models_folder
from bath_drake.safety.self_distance import capsule_ends, self_distance
from bath_drake.scenario import find_skill, load_scenario
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.simulation import run
from bath_drake.skill_file import load_skill
from bath_drake.verification import evaluate

# %% [markdown]
# ## A folder of one's own
#
# A URDF: seven revolute joints in a row from the link `base` to the link `nozzle_tip`
# (z along the jet), a transmission for each, collision and visual geometry. Beside
# it, if one likes, a YAML file of the same name with home, posture and place
# (docs/arms.md).

# %%
folder = Path(tempfile.mkdtemp())
for suffix in ("urdf", "yaml"):
    source = models_folder() / "arm" / f"iiwa14_nozzle.{suffix}"
    shutil.copy(source, folder / f"my_arm.{suffix}")
scenario_file = folder / "my_scenario.yaml"
scenario_file.write_text(
    f"""
description: The pouring stroke by an arm of my own.
duration: 30.0
perception: ideal
scene:
  person: f_avg
  arm:
    model: {folder / "my_arm.urdf"}
    fidelity: kinematic
"""
)
scenario = load_scenario(scenario_file)
skill = load_skill(find_skill(scenario.skill))

# %% [markdown]
# ## What is read out of the file
#
# The chain of links, and a capsule around each piece of collision geometry: from
# these the guard is told how near links come to each other. At home they are far from
# touching.

# %%
chain = arm_chain(scenario.scene.arm)
home = np.array(scenario.scene.arm.home)
print(f"{len(chain.capsules)} capsules, {len(chain.pairs)} pairs that must not touch")
print(f"at home the nearest two are {1e3 * self_distance(home, chain):.0f} mm apart")

figure, axes = plt.subplots(subplot_kw={"projection": "3d"})
for ends, row in zip(capsule_ends(home, chain), chain.capsules, strict=True):
    axes.plot(*ends.T, linewidth=100 * row[7], solid_capstyle="round", alpha=0.6)
axes.set_aspect("equal")
axes.set_title("The arm at home, in its base's frame")
axes.set_xlabel("x, m")
axes.set_ylabel("y, m")
axes.set_zlabel("z, m")

# %% [markdown]
# ## Does it get there?
#
# The path is followed as the inverse kinematics follows it, with the person in every
# pose; and so is the whole back. What `bath-drake reach` prints is this.

# %%
found = reachability(scenario, skill)
print("\n".join(found.lines()))
print(f"{100 * found.back.share:.0f} % of the back is within reach")

# %% [markdown]
# ## It washes
#
# The Diagram is the same, wire for wire: nothing in it knows which arm this is but by
# the model that it was built with.

# %%
log = run(build_reproduction(scenario, skill), scenario)
metrics = evaluate(log, scenario, skill).metrics
print(log.outcome, {name: check["pass"] for name, check in metrics["checks"].items()})
assert metrics["verdict"] == "pass"
shutil.rmtree(folder)
plt.show()
