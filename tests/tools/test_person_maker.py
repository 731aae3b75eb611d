"""People are made of MakeHuman's data as their recipes say.

The data are no dependency: `make people` makes everybody again. Here a rig of four
joints stands for MakeHuman's.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from make_people import RECIPES, main
from person_maker.makehuman import Body, MakeHuman, MakeHumanError
from person_maker.parts import vertex_normals
from person_maker.phenotypes import Phenotype, shares, targets
from person_maker.recipes import RecipeError, read_recipes
from person_maker.seating import joint_pose, skinned

from bath_drake.patient.gltf import read_part
from bath_drake.patient.people import load_person, shipped_people

TYPES, AT = ("min", "average", "max"), (0.0, 0.5, 1.0)
AVERAGE = {"muscle": 0.5, "weight": 0.5, "height": 0.4, "proportions": 0.5}
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
CUBE_TRIANGLES = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ]
)


@pytest.fixture
def human():
    """A trunk of two joints, with an arm of two."""
    return SimpleNamespace(
        names=["root", "spine", "arm", "hand"],
        parents=np.array([-1, 0, 1, 2]),
        weights=np.eye(4),
    )


@pytest.fixture
def standing(rng):
    joints = np.tile(np.eye(4), (4, 1, 1))
    joints[:, :3, :3], _ = np.linalg.qr(rng.normal(size=(4, 3, 3)))
    joints[:, :3, :3] *= np.linalg.det(joints[:, :3, :3])[:, None, None]
    joints[:, :3, 3] = [[0, 0, 1], [0, 0, 1.4], [0.2, 0, 1.4], [0.5, 0, 1.4]]
    return Body(joints[:, :3, 3] + rng.normal(scale=0.05, size=(4, 3)), joints)


def quarter(axis):
    a, b = {"x": (1, 2), "z": (0, 1)}[axis]
    R = np.eye(3)
    R[[a, b], [a, b]], R[a, b], R[b, a] = 0.0, -1.0, 1.0
    return R


@pytest.mark.parametrize("value", [-0.2, 0.0, 0.3, 0.5, 0.7, 1.0, 1.9])
def test_shares_sum_to_one_and_have_the_value_as_their_mean(value):
    found = shares(value, TYPES, AT)
    assert sum(found.values()) == pytest.approx(1.0)
    assert sum(found[t] * a for t, a in zip(TYPES, AT, strict=True)) == pytest.approx(
        value
    )


def test_a_pure_type_is_made_of_its_targets_alone():
    who = Phenotype(
        gender=1.0, age=1.0, muscle=0.5, weight=1.0, height=0.0, proportions=0.0
    )
    found = {str(path): amount for path, amount in targets(who)}
    kind = "female-old-averagemuscle-maxweight"
    assert found == pytest.approx(
        {f"macrodetails/universal-{kind}.target.gz": 1.0}
        | {
            f"macrodetails/{race}-female-old.target.gz": 1.0 / 3.0
            for race in ("african", "asian", "caucasian")
        }
        | {
            f"macrodetails/height/{kind}-minheight.target.gz": 1.0,
            f"macrodetails/proportions/{kind}-idealproportions.target.gz": 1.0,
            "breast/female-old-averagemuscle-maxweight-averagecup-averagefirmness"
            ".target.gz": 1.0,
        }
    )


def test_men_have_no_target_of_breasts():
    who = Phenotype(gender=0.0, age=0.8, **AVERAGE)
    assert not [path for path, _ in targets(who) if path.parts[0] == "breast"]


def test_without_turns_the_body_stays_as_it_stands(human, standing):
    pose = joint_pose(human, standing, {})
    np.testing.assert_allclose(
        skinned(human, standing, pose), standing.vertices, atol=1e-12
    )


def test_a_turned_joint_carries_all_that_hangs_on_it(human, standing):
    R = quarter("z")
    pose = joint_pose(human, standing, {"arm": R})
    found = skinned(human, standing, pose)
    shoulder = standing.joints[2, :3, 3]
    np.testing.assert_allclose(found[:2], standing.vertices[:2], atol=1e-12)
    expected = shoulder + (standing.vertices[2:] - shoulder) @ R.T
    np.testing.assert_allclose(found[2:], expected, atol=1e-12)


def test_a_turn_is_about_axes_that_the_parent_carries_along(human, standing):
    R_spine, R_arm = quarter("x"), quarter("z")
    pose = joint_pose(human, standing, {"spine": R_spine, "arm": R_arm})
    found = skinned(human, standing, pose)
    waist, shoulder = standing.joints[1, :3, 3], standing.joints[2, :3, 3]
    # First the arm about the standing body's axes, then all of it with the spine.
    arm = shoulder + (standing.vertices[2] - shoulder) @ (R_spine.T @ R_arm @ R_spine).T
    np.testing.assert_allclose(found[2], waist + (arm - waist) @ R_spine.T, atol=1e-12)


def test_an_unknown_joint_cannot_be_turned(human, standing):
    with pytest.raises(ValueError, match="no such joint: tail"):
        joint_pose(human, standing, {"tail": np.eye(3)})


def test_normals_do_not_depend_on_how_a_face_is_cut():
    normals = vertex_normals(CUBE, CUBE_TRIANGLES)
    np.testing.assert_allclose(normals, (2.0 * CUBE - 1.0) / np.sqrt(3.0), atol=1e-12)


def test_there_is_a_recipe_for_everybody_who_ships():
    recipes = read_recipes(RECIPES)
    assert sorted(recipes) == list(shipped_people())
    for name, recipe in recipes.items():
        person = load_person(name)
        assert person.name == recipe.name
        colours = {"hair": recipe.hair, "trunks": recipe.trunks}
        for part in ("body", "back", "hair", "trunks"):
            rgba = read_part(person.part_path(part)).rgba
            # The first four files have their colours as bytes / 255 in six digits.
            np.testing.assert_allclose(
                255.0 * rgba, [*colours.get(part, recipe.skin), 255], atol=1e-3
            )


RECIPE = """somebody:
  name: somebody
  phenotype: {gender: 1, age: 0.8, muscle: 0.5, weight: 1, height: 0.4, proportions: 1}
  skin: [200, 150, 120]
  hair: [50, 38, 30]
  trunks: [30, 40, 90]
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("somebody:\n", "../up:\n", r"\.\./up: a folder's name"),
        ("age: 0.8", "age: 0.3", "somebody.phenotype.age: found 0.3, allowed 0.667"),
        ("weight: 1", "weight: 2.1", "weight: found 2.1, allowed 0 to 2"),
        ("muscle: 0.5", "muscle: .nan", "not finite"),
        ("height: 0.4, ", "", "height: is missing"),
        ("gender: 1", "gender: 1, mood: 1", "mood: unknown key"),
        ("150, 120]", "150, 256]", "skin: found 256, allowed 0 to 255"),
        ("150, 120]", "150]", "skin: found 2 items, expected 3"),
        ("  hair:", "  beard:", "hair: is missing"),
    ],
)
def test_a_wrong_recipe_is_refused_by_key(tmp_path, old, new, message):
    path = tmp_path / "people.yaml"
    path.write_text(RECIPE)
    assert read_recipes(path)["somebody"].phenotype.weight == 1.0
    path.write_text(RECIPE.replace(old, new, 1))
    with pytest.raises(RecipeError, match=message):
        read_recipes(path)


def test_missing_data_are_named(tmp_path):
    with pytest.raises(MakeHumanError, match=r"base\.obj"):
        MakeHuman(tmp_path)


def test_the_program_refuses_whom_it_has_no_recipe_for(tmp_path, capsys):
    arguments = ["nobody", "--data", str(tmp_path), "--out", str(tmp_path / "made")]
    assert main(arguments) == 2
    assert "nobody: no recipe; there are: f_thin" in capsys.readouterr().err
    assert not (tmp_path / "made").exists()
