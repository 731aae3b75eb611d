"""Backgrounds are seen behind and beside the person, and change nothing of them."""

import functools

import numpy as np
import pytest
from pydrake.geometry import SceneGraph
from pydrake.systems.framework import DiagramBuilder

from bath_drake.patient.people import load_person
from bath_drake.scene.backgrounds import CLUTTER_LABEL, SECOND_PERSON_LABEL
from bath_drake.scene.camera import add_camera
from bath_drake.scene.config import BACKGROUNDS, SceneConfig, check_scene
from bath_drake.scene.room import ROOM_LABEL
from bath_drake.scene.studio import PERSON_LABELS, add_studio

OTHERS = tuple(name for name in BACKGROUNDS if name != "plain")
SEEN = {
    "tan_wall": ROOM_LABEL,
    "dark_wall": ROOM_LABEL,
    "clutter": CLUTTER_LABEL,
    "second_person": SECOND_PERSON_LABEL,
}


@functools.cache
def pictured(background, person="f_thin"):
    """Colour and label image of a person at rest before a background."""
    builder, scene_graph = DiagramBuilder(), SceneGraph()
    builder.AddNamedSystem("scene_graph", scene_graph)
    config = SceneConfig(person=person, background=background)
    studio = add_studio(builder, scene_graph, config, load_person(person))
    camera = add_camera(builder, scene_graph, config.camera, studio.skin_by_geometry())
    diagram = builder.Build()
    view = camera.GetMyContextFromRoot(diagram.CreateDefaultContext())
    colour = camera.color_image_output_port().Eval(view).data[..., :3].copy()
    label = camera.label_image_output_port().Eval(view).data[..., 0].copy()
    return colour.astype(int), label


@pytest.mark.render
@pytest.mark.parametrize("background", OTHERS)
def test_the_person_is_seen_as_before_a_plain_one(background):
    _, label = pictured(background)
    _, plain = pictured("plain")
    ours = np.isin(plain, list(PERSON_LABELS.values()))
    np.testing.assert_array_equal(label[ours], plain[ours])
    assert not np.isin(label[~ours], list(PERSON_LABELS.values())).any()


@pytest.mark.render
@pytest.mark.parametrize("background", OTHERS)
def test_a_background_is_in_the_picture(background):
    colour, label = pictured(background)
    plain, _ = pictured("plain")
    theirs = label == SEEN[background]
    # A twentieth of the picture, and of other colours than the plain room.
    assert theirs.mean() > 0.05
    assert np.abs(colour - plain)[theirs].max(axis=1).mean() > 20


@pytest.mark.render
def test_a_tan_wall_has_the_hue_of_skin_and_a_dark_one_is_dark():
    tan, label = pictured("tan_wall")
    red, green, blue = tan[label == ROOM_LABEL].mean(axis=0)
    assert red > green > blue
    dark, label = pictured("dark_wall")
    # But for the clear colour where there is no room.
    assert np.median(dark[label == ROOM_LABEL].max(axis=1)) < 110


@pytest.mark.render
def test_the_second_person_is_somebody_else():
    with_other, _ = pictured("second_person", "f_avg")
    alone, _ = pictured("plain", "f_avg")
    assert np.abs(with_other - alone).max() > 50


def test_another_background_is_refused_by_name():
    with pytest.raises(ValueError, match=r"background: found 'beach', allowed: plain"):
        check_scene(SceneConfig(background="beach"))
