import numpy as np
import pytest

from bath_drake.perception.faults import (
    DropletsFault,
    FaultsConfig,
    FrameFault,
    LateFault,
    SaturationFault,
    check_faults,
)
from bath_drake.perception.lens_faults import droplets, with_lens_faults

HEIGHT, WIDTH = 120, 160


def images():
    rng = np.random.default_rng(0)
    colour = rng.integers(0, 256, (HEIGHT, WIDTH, 4), dtype=np.uint8)
    return colour, np.full((HEIGHT, WIDTH), 1.2, dtype=np.float32)


def taken(config, **options):
    return with_lens_faults(
        *images(), config, **({"seed": 1, "frame": 0, "t": 1.0} | options)
    )


def wet(water, seed=1):
    """The pixels that the droplets cover."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    covered = np.zeros((HEIGHT, WIDTH), dtype=bool)
    for x, y, r in droplets(water.count, water.radius * WIDTH, WIDTH, HEIGHT, seed):
        covered |= (u - x) ** 2 + (v - y) ** 2 <= r**2
    return covered


def test_a_glare_is_white_without_depth_and_nothing_else_changes():
    colour, depth = images()
    glare = SaturationFault(centre=[0.25, 0.5], radius=0.1)
    bright, found = taken(FaultsConfig(saturation=glare))
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    disc = (u - 40.0) ** 2 + (v - 60.0) ** 2 <= 16.0**2
    assert (bright[disc] == 255).all()
    assert (found[disc] == 0.0).all()
    np.testing.assert_array_equal(bright[~disc], colour[~disc])
    np.testing.assert_array_equal(found[~disc], depth[~disc])


def test_water_blurs_colour_and_spoils_depth_where_it_is():
    colour, depth = images()
    water = DropletsFault(count=4, radius=0.1)
    blurred, found = taken(FaultsConfig(droplets=water))
    covered = wet(water)
    assert covered.sum() > 500
    np.testing.assert_array_equal(blurred[~covered], colour[~covered])
    np.testing.assert_array_equal(found[~covered], depth[~covered])
    # White noise of deviation 74, averaged over a hundred pixels and more.
    assert blurred[covered][:, :3].std() < 0.3 * colour[covered][:, :3].std()
    inside = found[covered]
    lost, wild = inside == 0.0, (inside != 0.0) & (inside != depth[0, 0])
    # Some 1,500 pixels; where droplets overlap, more than one spoils them.
    assert lost.mean() == pytest.approx(water.lost, abs=0.1)
    assert wild.mean() == pytest.approx(water.outliers, abs=0.1)
    assert inside[~lost].min() > 0.3 * 1.2
    assert inside[~lost].max() < 2.3 * 1.2


def test_the_water_stays_and_the_wrong_depths_do_not():
    config = FaultsConfig(droplets=DropletsFault(count=4, radius=0.1))
    first, again, other = (taken(config, frame=k) for k in (0, 0, 1))
    for a, b in zip(first, again, strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(first[0], other[0])
    assert (first[1] != other[1]).any()
    assert (taken(config, seed=2)[0] != first[0]).any()


@pytest.mark.parametrize("t", [0.4, 2.0])
def test_before_and_after_its_while_a_fault_does_nothing(t):
    span = {"begin": 0.5, "end": 2.0}
    config = FaultsConfig(
        saturation=SaturationFault(**span), droplets=DropletsFault(**span)
    )
    for found, given in zip(taken(config, t=t), images(), strict=True):
        np.testing.assert_array_equal(found, given)


def test_a_droplet_may_hang_over_the_images_edge():
    water = DropletsFault(count=30, radius=0.2)
    colour, depth = taken(FaultsConfig(droplets=water))
    assert colour.shape == (HEIGHT, WIDTH, 4)
    assert depth.shape == (HEIGHT, WIDTH)


@pytest.mark.parametrize(
    ("faults", "message"),
    [
        ({"loss": FrameFault(begin=2.0, end=1.0)}, "loss: found begin 2.0"),
        ({"frozen": FrameFault(probability=1.5)}, "frozen.probability: found 1.5"),
        ({"late": LateFault(delay=-0.1)}, "late.delay: found -0.1"),
        ({"saturation": SaturationFault(centre=[2.0, 0])}, "saturation.centre: found"),
        ({"saturation": SaturationFault(radius=0.0)}, "saturation.radius: found 0.0"),
        ({"droplets": DropletsFault(count=0)}, "droplets.count: found 0"),
        ({"droplets": DropletsFault(lost=0.9)}, "droplets.lost and outliers"),
    ],
)
def test_what_makes_no_fault_is_refused_by_name(faults, message):
    with pytest.raises(ValueError, match=message):
        check_faults(FaultsConfig(**faults))
    check_faults(FaultsConfig())
    assert not FaultsConfig().any
    assert FaultsConfig(**faults).any
