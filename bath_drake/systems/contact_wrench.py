"""What the skin truly does to the tool, out of the plant's contacts."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import GeometryId
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import BasicVector, LeafSystem

from bath_drake.systems._ports import eval_value, set_vector


class ContactWrench(LeafSystem):
    """Adds up the hydroelastic contacts of the tool.

    .. pydrake_system::

        name: ContactWrench
        input_ports:
        - contact_results
        - nozzle_pose
        output_ports:
        - contact_wrench

    `contact_results` are the plant's, `nozzle_pose` is X_WE. `contact_wrench` (6) is
    on the tool, at E's origin, in E: torque, N m, then force, N. It is the truth: for
    the force sensor and for logs. Stateless.
    """

    def __init__(self, *, tool: frozenset[GeometryId]) -> None:
        """Declares the ports; raises ValueError without a geometry of the tool."""
        super().__init__()
        if not tool:
            raise ValueError("tool must have at least one geometry, got none")
        self._tool = tool
        self._results = self.DeclareAbstractInputPort(
            "contact_results", Value(ContactResults())
        )
        self._pose = self.DeclareAbstractInputPort(
            "nozzle_pose", Value(RigidTransform())
        )
        self.DeclareVectorOutputPort(
            "contact_wrench",
            6,
            self._calc,
            {self._results.ticket(), self._pose.ticket()},
        )

    def _calc(self, context: Any, output: BasicVector) -> None:
        results: Any = eval_value(self._results, context, ContactResults)
        X_WE = eval_value(self._pose, context, RigidTransform)
        p_WE = np.array(X_WE.translation())
        wrench_W = np.zeros(6)
        for k in range(results.num_hydroelastic_contacts()):
            contact = results.hydroelastic_contact_info(k)
            surface, F_Ac_W = contact.contact_surface(), contact.F_Ac_W()
            # The force is on the body of geometry M.
            on_tool = surface.id_M() in self._tool
            if on_tool == (surface.id_N() in self._tool):
                continue
            sign = 1.0 if on_tool else -1.0
            force = sign * np.array(F_Ac_W.translational())
            torque = sign * np.array(F_Ac_W.rotational())
            arm = np.array(surface.centroid()) - p_WE
            wrench_W += np.concatenate([torque + np.cross(arm, force), force])
        R_EW = np.array(X_WE.rotation().matrix()).T
        set_vector(output, np.concatenate([R_EW @ wrench_W[:3], R_EW @ wrench_W[3:]]))
