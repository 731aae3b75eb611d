"""How fast a whole composition is proved: the shipped figure of eight."""

from functools import partial

from bath_drake.benchmarks.figures import Figure
from bath_drake.benchmarks.timing import best_seconds
from bath_drake.certificate.certify import certify
from bath_drake.composition.certify import certify_chain
from bath_drake.scenario import find_skill
from bath_drake.skill_file import load_skill

_SKILL = "figure_eight.yaml"
_REPEATS = 5


def chain_proof() -> list[Figure]:
    """A chain's certificate: its time, beside that of its fields one by one."""
    chain = load_skill(find_skill(_SKILL)).chain
    certificate = certify_chain(chain)
    whole = best_seconds(partial(certify_chain, chain), _REPEATS)
    fields = sum(best_seconds(partial(certify, f), _REPEATS) for f in chain.fields)
    gates = [handover.boxes for handover in certificate.handovers]
    return [
        Figure("proof_chain", 1e3 * whole, "ms"),
        Figure("proof_chain_to_its_fields", whole / fields, "x"),
        Figure("proof_chain_fields", len(chain)),
        Figure("proof_chain_boxes_a_gate", max(gates)),
        Figure("proof_chain_proved", float(certificate.passed)),
    ]
