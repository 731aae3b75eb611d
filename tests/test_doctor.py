from bath_drake.doctor import (
    Finding,
    examine_packages,
    examine_system,
    fixing_line,
    run_doctor,
)

MISSING = Finding("libEGL.so.1", "missing", False, "libegl1")


def test_all_is_well_where_the_tests_run(capsys):
    assert run_doctor() == 0
    out = capsys.readouterr().out
    for finding in examine_system() + examine_packages():
        assert finding.name in out


def test_one_line_installs_all_that_is_missing():
    line = fixing_line([MISSING, Finding("x", "found", True, "libx")])
    assert line.endswith("apt-get install -y libegl1")
    assert "\n" not in line


def test_nothing_missing_needs_no_line():
    assert fixing_line([]) == ""
