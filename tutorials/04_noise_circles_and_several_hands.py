# %% [markdown]
# # From recordings to strokes: noise, circles, and several hands
#
# Before anything is learned, recordings are processed: outliers and tremor are taken
# out, circles are told from the slow motion below them, and demonstrations are laid
# beside each other. Here we watch each step where the truth is known.

# %%
import matplotlib.pyplot as plt
import numpy as np

from bath_drake.benchmarks.composites import random_composite
from bath_drake.benchmarks.denoising import METHODS, errors, noisy_stroke
from bath_drake.demonstrations.denoise import denoise
from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.demonstrations.separation import separate
from bath_drake.demonstrations.strokes import STROKES
from bath_drake.learning.periodic import learn_cycle
from bath_drake.resources import models_folder

# %% [markdown]
# ## Noise
#
# A zigzag as a hand with tremor (4 to 12 Hz) would make it, seen by a camera that
# counts in whole millimetres and errs by 5 cm now and then. A low-pass filter would
# take the tremor and the corners with it. Our smoothing spline starts as stiff, but may
# not stray: on average over a quarter of a second it stays within 0.5 % of the
# recording. Tremor cancels out over that time, a cut corner does not.

# %%
zigzag = next(stroke for stroke in STROKES if stroke.name == "zigzag")
noisy = noisy_stroke(zigzag, np.random.default_rng(1))
smooth = denoise(noisy.t, noisy.points)
outliers = smooth.outliers

fig, axes = plt.subplots(figsize=(7, 5))
axes.plot(*noisy.points.T, color="0.7", lw=0.8, label="recorded")
axes.plot(*noisy.points[outliers].T, "rx", label="left out")
axes.plot(*smooth(noisy.t).T, color="#d7301f", lw=2, label="denoised")
axes.plot(*noisy.truth.T, "k--", lw=1, label="what the hand meant")
axes.set(xlabel="x, m", ylabel="y, m", aspect="equal", title="A zigzag, denoised")
axes.legend()
plt.show()

# %% [markdown]
# How do the usual filters compare? Each gets the same recordings, outliers taken out,
# and the parameter that serves it best. `bath-drake bench demonstrations` does the same
# over all shipped strokes.

# %%
chosen = {
    "smoothing spline, tolerance": 0.0,
    "Savitzky-Golay": 0.7,
    "zero-phase low-pass": 2.0,
}
recordings = [
    noisy_stroke(stroke, np.random.default_rng([3, k]))
    for k, stroke in enumerate(STROKES)
]
found = {
    name: [errors(METHODS[name][0], r, parameter) for r in recordings]
    for name, parameter in chosen.items()
}
fig, axes = plt.subplots(figsize=(7, 4))
for name, left in found.items():
    axes.plot(np.sort([100 * e.frechet for e in left]), "o-", ms=3, label=name)
axes.set(
    xlabel="30 strokes, the best first",
    ylabel="Fréchet distance to the truth,\n% of the longest side",
    title="What three smoothers leave",
)
axes.legend()
plt.show()
worst = {name: max(e.frechet for e in left) for name, left in found.items()}
print({name: round(value, 4) for name, value in worst.items()})

# %% [markdown]
# ## Circles
#
# A slow stroke with circles on top comes apart into x(t) = discrete(t) +
# periodic(phase(t)). The period, which drifts, and the size of the circles are found by
# the data alone.

# %%
made = random_composite(np.random.default_rng(11))
parts = separate(made.t, made.points)
fig, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5))
left.plot(*made.points.T, color="0.7", lw=0.8, label="recorded")
left.plot(*parts.discrete.T, color="#d7301f", lw=2, label="discrete part, found")
left.plot(*made.discrete.T, "k--", lw=1, label="discrete part, true")
left.set(xlabel="x, m", ylabel="y, m", aspect="equal")
left.legend()
right.plot(parts.t, 100 * parts.periodic, lw=1)
right.set(
    xlabel="time, s", ylabel="periodic part, cm", title=f"{parts.cycles:.1f} cycles"
)
plt.show()
print(f"period {parts.period:.3f} s, true {made.period:.3f} s")

# %% [markdown]
# A stroke without circles comes back as it is, bit for bit.

# %%
sinusoid = read_recording(models_folder() / "demonstrations" / "back_sinusoid_1.csv")
assert np.array_equal(separate(sinusoid.t, sinusoid.points).discrete, sinusoid.points)

# %% [markdown]
# ## Several hands
#
# Three demonstrations of scrubbing, by hands of other speeds and sizes, that begin
# their ovals anywhere. Strokes are moved as wholes to end at one goal; cycles are
# turned onto each other and averaged. One that was broken off, here a copy that stops
# half-way, does not move the goal: it is left out, and the reason is said.

# %%
folder = models_folder() / "demonstrations"
hands = [read_recording(folder / f"scrubbing_{k}.csv") for k in (1, 2, 3)]
half = len(hands[0].t) // 2
broken = type(hands[0])(
    path=hands[0].path.with_name("broken_off.csv"),
    t=hands[0].t[:half],
    points=hands[0].points[:half],
    metadata=hands[0].metadata,
    sha256="",
)
demonstrations, frame = canonical_demonstrations([*hands, broken])
for demonstration in demonstrations:
    print(f"{demonstration.name}: {demonstration.stray or 'belongs to the others'}")
together = [d for d in demonstrations if not d.stray]
cycle = learn_cycle(together).cycle

fig, (left, right) = plt.subplots(1, 2, figsize=(11, 5))
for d in demonstrations:
    left.plot(*d.raw.T, color="0.75", lw=0.6)
    left.plot(*d.points.T, ":" if d.stray else "-", lw=2, label=d.name)
left.set(xlabel="x in N", ylabel="y in N", aspect="equal", title="Discrete parts")
left.legend()
for d in together:
    right.plot(*d.periodic.offsets.T, color="0.75", lw=0.6)
right.plot(*cycle.offset(np.linspace(0, 2 * np.pi, 200)).T, "r", lw=2, label="learned")
right.set(xlabel="x in N", ylabel="y in N", aspect="equal", title="Cycles")
right.legend()
plt.show()

# %%
ours, *others = worst.values()
assert ours < min(others)
assert abs(parts.period / made.period - 1.0) < 0.03
assert [bool(d.stray) for d in demonstrations] == [False, False, False, True]
