# %% [markdown]
# # The navigation function, and why learning it is not convex
#
# The robot washes along the gradient of one scalar function φ. A carer's stroke is
# learned by placing *virtual obstacles* that bend this gradient the right way. Here we
# look at φ itself, and then at the paper's Section III-B: the smallest learning
# problem there is, one obstacle with one coordinate, already defeats gradient descent.

# %%
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Circle
from pydrake.symbolic import Expression, MakeVectorVariable
from scipy.optimize import differential_evolution

from bath_drake.certificate.certify import certify
from bath_drake.field.navigation import NavigationField, phi
from bath_drake.field.obstacles import ObstacleSet, Workspace, beta
from bath_drake.field.rollout import RolloutStatus, rollout
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.paper.descent import descend as learner_descent
from bath_drake.report import style
from bath_drake.systems.navigation_function import NavigationFunction

# %% [markdown]
# ## The function
#
# With γ = |q − q_d|², the squared distance to the goal q_d, and β the product of one
# function per boundary, positive in free space and zero on the boundary, the paper's
# Eq. 1 is
#
#     φ = γ / (γ^κ + β)^(1/κ)
#
# φ is 0 at the goal and 1 on every boundary, and the robot follows q̇ = −∇φ (Eq. 2).
# Our world for today: a disc of radius 2 to move in, a start and a goal on the y-axis
# at equal distances from the x-axis, and one round obstacle with its centre at x₁ on
# the x-axis.

# %%
RADIUS = 0.4  # of the obstacle
START, GOAL = np.array([0.0, 0.8]), np.array([0.0, -0.8])
KAPPA = 40.0


def world(x1, kappa=KAPPA):
    """The field with its obstacle at (x1, 0)."""
    return NavigationField(
        workspace=Workspace(np.zeros(2), np.full(2, 2.0)),
        goal=GOAL,
        kappa=kappa,
        obstacles=ObstacleSet(np.array([[x1, 0.0, RADIUS, RADIUS, 0.0]])),
    )


def path(x1, kappa=KAPPA):
    """The robot's path from START, points 0.01 apart."""
    return rollout(START, world(x1, kappa), step=0.01).path


# %% [markdown]
# κ decides how far an obstacle is felt. The paths do not depend on how φ is scaled:
# they are those of ψ = κ ln γ − ln β, where the goal's pull is multiplied by κ and the
# obstacles' push is not. With a large κ the robot goes straight and turns away late,
# and φ becomes a flat plateau with a funnel at the goal, which is why everything here
# is computed with logarithms. (For disjoint discs a κ large enough is also what keeps φ
# free of traps.)

# %%
with style.figure_style():
    figure, panels = plt.subplots(1, 3, figsize=(10.0, 3.3), layout="constrained")
    x, y = np.meshgrid(np.linspace(-2.0, 2.0, 321), np.linspace(-2.0, 2.0, 321))
    inside = np.hypot(x, y) < 2.0
    turns = np.linspace(0.0, 2.0 * np.pi, 28, endpoint=False)
    for axes, kappa in zip(panels, (2.0, 8.0, KAPPA), strict=True):
        field = world(-0.3, kappa)
        height = np.where(inside, phi(np.stack([x, y], axis=-1), field), np.nan)
        image = axes.pcolormesh(
            x, y, height, cmap="Blues", vmin=0.0, vmax=1.0, rasterized=True
        )
        for turn in turns:
            begin = 1.93 * np.array([np.cos(turn), np.sin(turn)])
            line = rollout(begin, field, step=0.01).path
            axes.plot(*line.T, color=style.INK, linewidth=0.7)
        axes.add_patch(Circle((-0.3, 0.0), RADIUS, color=style.OBSTACLE))
        axes.add_patch(Circle((0.0, 0.0), 2.0, fill=False, color=style.OBSTACLE))
        axes.plot(*GOAL, "*", color=style.REPRODUCTION, markersize=13)
        axes.set(aspect="equal", title=f"κ = {kappa:g}")
        axes.axis("off")
    figure.colorbar(image, ax=panels, label="φ")
    plt.show()

# %% [markdown]
# ## The same function in Drake
#
# `NavigationFunction` is a Drake system that converts to AutoDiffXd and to symbolic
# Expressions, for verification and trajectory optimisation. In symbols it *is* Eq. 1,
# and its flow is a polynomial: what sums-of-squares tools ask for.

# %%
symbolic = NavigationFunction(field=world(-0.3, kappa=3.0)).ToSymbolic()
context = symbolic.CreateDefaultContext()
position = [Expression(variable) for variable in MakeVectorVariable(2, "q")]
symbolic.GetInputPort("canonical_position").FixValue(context, position)
print(symbolic.GetOutputPort("phi").Eval(context)[0])

# %% [markdown]
# ## Four cases (the paper's Fig. 3)
#
# Without the obstacle the robot would go straight down the y-axis. Call x₂ the
# *deflection*: the x-coordinate of the path's point farthest from the y-axis. It has a
# sign, positive to the right.


# %%
def deflection(line):
    """The x-coordinate of the point of a path (n, 2) farthest from the y-axis."""
    return line[np.argmax(np.abs(line[:, 0])), 0]


CASES = {"I": -1.3, "II": -0.15, "III": 0.15, "IV": 1.3}
with style.figure_style():
    figure, panels = plt.subplots(1, 4, figsize=(10.0, 2.3), layout="constrained")
    for axes, (case, x1) in zip(panels, CASES.items(), strict=True):
        line = path(x1)
        x2 = deflection(line)
        axes.axvline(0.0, color=style.MUTED, linewidth=0.8)
        axes.axhline(0.0, color=style.MUTED, linewidth=0.8)
        axes.add_patch(Circle((x1, 0.0), RADIUS, color=style.OBSTACLE, alpha=0.85))
        axes.plot(x1, 0.0, "+", color="white", markersize=8)
        axes.plot(*line.T, color=style.REPRODUCTION, linewidth=2.2)
        axes.plot(*START, "o", color=style.INK, markersize=6)
        axes.plot(*GOAL, "*", color=style.INK, markersize=11)
        axes.set(aspect="equal", xlim=(-1.8, 1.8), ylim=(-1.05, 1.05))
        axes.set_title(f"{case}:  x₁ = {x1:g},  x₂ = {x2:+.2f}", loc="center")
        axes.axis("off")
    plt.show()

# %% [markdown]
# In I and IV the obstacle is away from the axis and the path stays on it (to a few
# hundredths: a navigation function feels every obstacle a little, the less the larger
# κ). In II the obstacle is on the negative side, reaches across the axis and pushes the
# path to the positive side: x₂ > 0. In III it is the other way round: x₂ < 0.
#
# ## The relation of x₁ and x₂ (the paper's Fig. 4)
#
# Now move the obstacle along the whole x-axis. The nearer its centre comes to the
# y-axis, the farther the path goes round, until at x₁ = 0 it snaps to the other side
# and the deflection jumps from its largest to its smallest value. Exactly at x₁ = 0 the
# robot runs head-on into a saddle of φ and is stuck: starts on this one line are.

# %%
assert rollout(START, world(0.0)).status is RolloutStatus.TRAPPED
LEFT, RIGHT = np.linspace(-1.5, -1e-3, 120), np.linspace(1e-3, 1.5, 120)
curves = {
    kappa: [
        np.array([deflection(path(x1, kappa)) for x1 in side]) for side in (LEFT, RIGHT)
    ]
    for kappa in (10.0, KAPPA, 160.0)
}
print(f"the jump: from {curves[KAPPA][0][-1]:+.2f} to {curves[KAPPA][1][0]:+.2f}")

# %% [markdown]
# ## Descent from Initial
#
# Suppose a carer's stroke passes on the left, as if there were an obstacle at Target,
# x₁ = 0.25. We look for it, starting from a guess Initial on the wrong side, by the
# paper's descent x₁ ← x₁ − ω dC/dx₁ on the Fréchet distance C between our path and the
# stroke (Section III-C), by central differences, the obstacle staying inside the
# workspace.

# %%
INITIAL, TARGET, LIMIT = -0.12, 0.25, 1.5
stroke = path(TARGET)


def cost(x1):
    """Discrete Fréchet distance of the obstacle's path to the stroke."""
    return discrete_frechet(path(x1), stroke)


def descend(x1, omega, iterations=200, difference=1e-3):
    """All iterates of the descent, until a step is shorter than 1e-4."""
    iterates = [x1]
    for _ in range(iterations):
        slope = (cost(x1 + difference) - cost(x1 - difference)) / (2.0 * difference)
        after = float(np.clip(x1 - omega * slope, -LIMIT, LIMIT))
        iterates.append(after)
        if abs(after - x1) < 1e-4:
            break
        x1 = after
    return np.array(iterates)


OMEGAS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
descents = {omega: descend(INITIAL, omega) for omega in OMEGAS}
for omega, iterates in descents.items():
    print(
        f"ω = {omega:4.2f}: {len(iterates) - 1:3d} steps to x₁ = {iterates[-1]:+.2f},"
        f" cost {cost(INITIAL):.2f} -> {cost(iterates[-1]):.2f}"
    )
FINAL = descents[0.1][-1]

# %% [markdown]
# Whatever the step, the descent runs *away*: pushing the obstacle further left makes
# the path straighter and the distance smaller, until the obstacle does nothing at all.
# That is Final. To reach Target it would have to go through the jump, uphill all the
# way and over a cliff.
#
# (The paper words it so: a point "on the left side of the diagram (with negative x₂
# deflection)" cannot move to "the right side (positive x₂ deflection)". That does not
# fit its own cases: II, obstacle left, has x₂ > 0. An obstacle repels, so x₁ and x₂
# have opposite signs, and we draw it so. The argument is the same for either sign.)

# %%
with style.figure_style():
    figure, (top, bottom) = plt.subplots(
        2, 1, figsize=(8.0, 7.0), sharex=True, layout="constrained"
    )
    looks = {
        10.0: {"color": style.DEMONSTRATION_SHADES[1], "linewidth": 1.2},
        KAPPA: {"color": style.DEMONSTRATION, "linewidth": 2.4, "zorder": 3},
        160.0: {"color": style.MUTED, "linewidth": 1.2},
    }
    for kappa, look in looks.items():
        left, right = curves[kappa]
        top.plot(LEFT, left, label=f"κ = {kappa:g}", **look)
        top.plot(RIGHT, right, **look)
        top.plot([0.0, 0.0], [left[-1], right[0]], ":", **look)
    top.axhline(0.0, color=style.MUTED, linewidth=0.8)
    top.set(ylim=(-0.6, 0.6), ylabel="deflection x₂")
    top.set_title("Where the path goes")
    top.legend(loc="lower left")
    for case, x1 in {"I": -1.0, "II": -0.27, "III": 0.27, "IV": 1.0}.items():
        top.text(x1, 0.53, case, ha="center", fontweight="bold", color=style.MUTED)
    for side in (LEFT, RIGHT):
        costs = [cost(x1) for x1 in side]
        bottom.plot(side, costs, color=style.DEMONSTRATION, linewidth=2.4)
    bottom.plot(
        descents[0.1],
        [cost(x1) for x1 in descents[0.1]],
        "o",
        color=style.INK,
        markersize=3.5,
        zorder=4,
        label="descent from Initial, ω = 0.1",
    )
    bottom.set(xlabel="centre of the obstacle x₁", ylabel="Fréchet distance C")
    bottom.set_title("What is minimised")
    bottom.legend(loc="upper right")
    marks = (
        ("Initial", INITIAL, style.INK, "right", (-10, -3)),
        ("Final", FINAL, style.REPRODUCTION, "center", (0, 10)),
        ("Target", TARGET, style.PASS, "left", (11, -3)),
    )
    for name, x1, colour, anchor, offset in marks:
        for axes, height in ((top, deflection(path(x1))), (bottom, cost(x1))):
            axes.plot(x1, height, "o", color=colour, markersize=9, zorder=5)
            axes.annotate(
                name,
                (x1, height),
                xytext=offset,
                textcoords="offset points",
                ha=anchor,
                color=colour,
                fontweight="bold",
            )
    plt.show()

# %% [markdown]
# ## A population
#
# The remedy (Section III-C) is to search with many obstacles at once, each taking its
# own descent. Here is the descent of our learner, which tries several lengths for every
# step, so that it settles in the tip of a valley. From everywhere on the right it ends
# at Target, and from nowhere on the left: one member on the right side is enough. An
# evolutionary search without any descent finds that side by itself.


# %%
def costs_of(members):
    """The cost of each member (n, 1) of a population, shape (n,)."""
    return np.array([cost(x1) for (x1,) in members])


members = np.linspace(-1.3, 1.3, 8)[:, np.newaxis]
ends, end_costs = learner_descent(
    costs_of,
    members,
    np.ones(1),
    iterations=30,
    clip=lambda xs: np.clip(xs, -LIMIT, LIMIT),
)
for (begin,), (end,), end_cost in zip(members, ends, end_costs, strict=True):
    print(f"from x₁ = {begin:+.2f} to {end:+.3f}, cost {end_cost:.3f}")
evolved = differential_evolution(
    lambda x: cost(x[0]), [(-LIMIT, LIMIT)], popsize=8, maxiter=20, rng=1, polish=False
)
print(f"evolution: x₁ = {evolved.x[0]:+.3f}, cost {evolved.fun:.3f}")

# %% [markdown]
# ## Is it a navigation function at all?
#
# Only if the goal is its one minimum: any other would trap the robot. The paper's
# theory promises that for discs and a large κ; learned obstacles are ellipses, may
# overlap, and promise nothing. So every field is *certified*, by interval arithmetic
# over the whole workspace: `proved` means that almost every start reaches the goal
# without touching a boundary, `refuted` comes with a trap. It takes milliseconds.


# %%
def known_world(kappa, *row):
    """A disc of radius 5 with one ellipse (centre x, y, semi-axes a, b, angle)."""
    return NavigationField(
        workspace=Workspace(np.zeros(2), np.full(2, 5.0)),
        goal=np.array([3.0, 0.0]),
        kappa=kappa,
        obstacles=ObstacleSet(np.array([row])),
    )


disc = known_world(4.0, 0.0, 0.0, 1.0, 1.0, 0.0)
broadside = known_world(10.0, -0.5, 0.0, 0.2, 1.6, 0.0)
certificates = {"a disc": certify(disc), "an ellipse, broadside": certify(broadside)}
for name, certificate in certificates.items():
    print(f"{name}: {certificate.verdict}, {1e3 * certificate.seconds:.1f} ms")
    print("   ", certificate.reason)
    for point in certificate.critical_points:
        print(f"    {point.kind} at ({point.x:+.5f}, {point.y:+.5f})")

# %% [markdown]
# Round the disc every path but one finds its way; the critical point behind it is a
# saddle, and a robot that is a hair off its line slides past. The flat side of the
# ellipse is a bay: what comes from the left ends in it, and no κ helps. We draw level
# curves of ψ, as φ is 1 to many digits where it gets interesting.


# %%
def potential(q, field):
    """The potential ψ at points (..., 2), not a number outside free space."""
    gamma = ((q - field.goal) ** 2).sum(axis=-1)
    outer, inner = field.workspace.beta(q), beta(q, field.obstacles).prod(axis=-1)
    free = (outer > 0.0) & (inner > 0.0)
    product = np.where(free, outer * inner, np.nan)
    return field.kappa * np.log(gamma) - np.log(product)


with style.figure_style():
    figure, panels = plt.subplots(1, 2, figsize=(10.0, 5.5), layout="constrained")
    x, y = np.meshgrid(np.linspace(-5.0, 5.0, 320), np.linspace(-5.0, 5.0, 320))
    turns = np.linspace(0.0, 2.0 * np.pi, 49)[:-1] + 0.03
    for axes, field, (name, certificate) in zip(
        panels, (disc, broadside), certificates.items(), strict=True
    ):
        height = potential(np.stack([x, y], axis=-1), field)
        levels = np.nanquantile(height, np.linspace(0.01, 0.99, 40))
        colours = {"colors": style.DEMONSTRATION_SHADES[0], "linestyles": "solid"}
        axes.contour(x, y, height, levels=levels, linewidths=0.6, **colours)
        for turn in turns:
            begin = 4.9 * np.array([np.cos(turn), np.sin(turn)])
            found = rollout(begin, field, step=0.02)
            trapped = found.status is RolloutStatus.TRAPPED
            colour = style.REPRODUCTION if trapped else style.PASS
            axes.plot(*found.path.T, color=colour, linewidth=1.0)
        axes.fill(*field.obstacles.boundary(128)[0].T, color=style.OBSTACLE)
        axes.add_patch(Circle((0.0, 0.0), 5.0, fill=False, color=style.OBSTACLE))
        for point in certificate.critical_points:
            marker = {"saddle": "X", "minimum": "v"}[point.kind]
            axes.plot(
                point.x,
                point.y,
                marker,
                color=style.BOX,
                markeredgecolor=style.INK,
                markersize=10,
            )
        axes.plot(*field.goal, "*", color=style.INK, markersize=14)
        axes.set_title(f"{name}: {certificate.verdict}", loc="center")
        axes.set(aspect="equal")
        axes.axis("off")
    plt.show()

# %% [markdown]
# (Green paths arrive, red ones do not; × is a saddle, ▼ the trap.) A refuted field may
# still be safe to use *from where we start*: with `starts` only the region that these
# can ever reach is certified.

# %%
print(certify(broadside, starts=[[4.0, 2.0], [2.0, -3.0]]).verdict, "on the right")
print(certify(broadside, starts=[[-4.0, 0.5]]).verdict, "from the left")

# %% [markdown]
# From here: `bath-drake learn` learns a skill of one field or more from recordings and
# `bath-drake certify` certifies any field in a file; every skill carries the
# certificate of its fields. Tutorial 02 is about the paper's learner, 03 about ours.
