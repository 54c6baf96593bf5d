"""A hand and a model -> what the solvers are given: substances, winding, held length, profiles."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from handgen.bending.model import BendModel, Choice
from handgen.bending.opposition import HingeCase, secant_modulus
from handgen.bending.strength import tearing_pressure
from handgen.errors import GeometryError, InputError, Problem
from handgen.geometry.actuator import profile_of, refuse_forbidden, thread_key
from handgen.geometry.profile import ActuatorProfile, FingerProfile
from handgen.materials import library
from handgen.mechanics.hinge import Pusher, flexibility
from handgen.parameters.load import Loaded
from handgen.simulation.case import Substance, Winding

STABLE = 1.5
"""Nominal strain up to which a law must be a possible material: what a chamber's wall sees below 100 kPa."""
BODIES = ("exoskeleton", "actuator")


@dataclass
class Composer:
    """Turns parts of one hand into parts of a case; what is wrong goes to `problems`."""

    loaded: Loaded
    model: BendModel
    model_file: str
    pressures: tuple[float, ...] = ()
    """MPa."""
    problems: list[Problem] = field(default_factory=list)

    def material(self, body: str) -> tuple[str, str]:
        """(name of the material of `body`, key path that says it)."""
        hand = self.loaded.hand
        if body == "actuator":
            return hand.casting.silicone.name, "casting.silicone.name"
        if hand.palm:
            return hand.printing.hand.material, "printing.hand.material"
        return hand.printing.finger.material, "printing.finger.material"

    def choice(self, body: str) -> Choice | None:
        """The parameter set of `body`, if the model has a usable one."""
        name, path = self.material(body)
        choice = self.model.materials.get(name)
        if choice is None:
            self._say(str(self.loaded.file), path, name,
                      f"the model {self.model.name} has no parameter set for it",
                      f"{', '.join(self.model.materials)}; or add it to `materials` of {self.model_file}")
            return None
        at, before = f"materials.{name}", len(self.problems)
        try:
            library.refuse_unstable(
                choice.parameters, STABLE, name=choice.name, file=self.model_file, path=at)
        except InputError as error:
            self.problems += error.problems
        if choice.density is None:
            self._say(self.model_file, f"{at}.density", None,
                      "missing: the library does not know the material", "density in kg/m3")
        return choice if len(self.problems) == before else None

    def substance(self, body: str) -> Substance | None:
        choice = self.choice(body)
        if choice is None:
            return None
        law = choice.parameters.build()
        return Substance(law, getattr(self.model.bulk_ratio, body) * law.shear_modulus, choice.density)

    def finger(self, name: str, curled: bool = True) -> FingerProfile:
        """The finger; an actuator on its own knows nothing of its curl: equal bends are equal cases."""
        finger = getattr(self.loaded.hand.fingers, name)
        if not curled:
            joints = [joint.model_copy(update={"rest_angle": 0.0}) for joint in finger.joints]
            finger = finger.model_copy(update={"joints": joints})
        return FingerProfile(finger)

    def actuator(self, name: str) -> ActuatorProfile | None:
        """Radii of the actuator as it is cast."""
        try:
            refuse_forbidden(self.loaded.hand, str(self.loaded.file))
            return profile_of(self.loaded.hand, name)
        except InputError as error:
            self.problems += error.problems
        except GeometryError as error:
            self._say(str(self.loaded.file), error.path, None, f"{error.part}: {error.message}")
        return None

    def winding(self, name: str, profile: ActuatorProfile) -> Winding | None:
        """The thread of actuator `name`, as wound on its large core."""
        thread, key = self.loaded.hand.thread_of(name), thread_key(self.loaded.hand, name)
        known = {n: m.elastic for n, m in library.library().materials.items() if m.elastic is not None}
        if thread.material not in known:
            self._say(str(self.loaded.file), f"{key}.material", thread.material,
                      "the library has no stiffness of this thread", "one of " + ", ".join(known))
            return None
        start, end = thread.held_back, profile.large_core_end - thread.held_back
        if end - start < thread.pitch:
            self._say(str(self.loaded.file), f"{key}.held_back", thread.held_back,
                      f"{end - start:.2f} mm are left to wind, less than a turn")
            return None
        depth = self.model.thread.depth
        if depth is None:
            depth = 0.0 if thread.groove else thread.diameter / 2
        return Winding(thread.pitch, thread.diameter, known[thread.material].young_mpa, depth, start, end)

    def held(self, profile: ActuatorProfile) -> float:
        """Length over which the base is held, mm; it must leave something to bend."""
        asked = self.model.held_length
        file, path = self.model_file, "held_length"
        if asked is None:
            asked, file, path = self.loaded.hand.seal.plug_length, str(self.loaded.file), "seal.plug_length"
        if asked >= profile.small_core_end:
            self._say(file, path, asked, "holds all of the chamber", f"below {profile.small_core_end:.2f} mm")
        return asked

    def bears(self, name: str, profile: ActuatorProfile, winding: Winding | None, held: float,
              substance: Substance | None) -> None:
        """The silicone must not tear: see `strength.tearing_pressure`."""
        silicone = self.loaded.hand.casting.silicone
        if winding is None or substance is None or held >= profile.small_core_end or not self.pressures:
            return
        asked = max(self.pressures)
        most = tearing_pressure(profile, winding.depth, held, substance.law, silicone.elongation / 100.0)
        if asked > most:
            self._say("command line", "--pressures", round(1e3 * asked, 6),
                      f"is above the range of {silicone.name}: the wall of the actuator {name} would stretch"
                      f" to its {silicone.elongation:g} % at break", f"0 to {1e3 * most:.0f} kPa")

    def hinge(self) -> HingeCase | None:
        """The thumb's hinge, its sheet left to `measured`; None if the hand or the model do not allow it."""
        from handgen.geometry.thumb import Hinge

        hand, pushers = self.loaded.hand, []
        tpu, silicone = self.substance("exoskeleton"), self.substance("actuator")
        for name, at in Hinge(hand).lines.items():
            profile = self.actuator(name)
            if profile is None:
                continue
            winding, held = self.winding(name, profile), self.held(profile)
            self.bears(name, profile, winding, held, silicone)
            if winding is not None:
                end, middle = profile.small_core_end, (held + profile.small_core_end) / 2
                pushers.append(Pusher(at, end - held, profile.small_core(middle),
                                      profile.large_core(middle) + winding.depth, profile.outer(middle)))
        if self.problems:
            return None
        return HingeCase((), tuple(pushers), 3.0 * tpu.law.shear_modulus, secant_modulus(silicone.law),
                         self.pressures)

    def measured(self, case: HingeCase) -> HingeCase:
        """`case` with the sheet as it lies in the hand's mesh.

        Raises:
            InputError: the hand cannot be made.
        """
        from handgen.checks.thumb import hinge_sections
        from handgen.geometry.hand import hand_part

        hand = self.loaded.hand
        try:
            sections, _ = hinge_sections(hand, hand_part(hand).triangles)
        except GeometryError as error:
            self._say(str(self.loaded.file), error.path, None, f"{error.part}: {error.message}")
            raise InputError(self.problems) from error
        sheet = flexibility(sections, hand.opposition.free_length)
        return replace(case, sheet=tuple(tuple(map(float, row)) for row in sheet))

    def _say(self, file: str, path: str, value: object, message: str, allowed: str | None = None) -> None:
        self.problems.append(Problem(file, path, value, message, allowed))

