//! The scene's equations as Python: what every program that is written shares.

/// The scene's numbers.
pub(super) const NUMBERS: &str = r#"
                    |MASS, LEVER = @mass@, @lever@  # kg felt at the lever's end, m
                    |START = (@theta@, @omega@)  # rad, rad/s
                    |DURATION, STEP = @duration@, @step@  # s
stops               |STOPS = (@low@, @high@)  # rad
motor               |MOTOR_MAX = @motor_max@  # N
motor_lag           |MOTOR_LAG = @motor_lag@  # s
brake               |BRAKE_MAX = @brake_max@  # N
brake coulomb       |DEAD_ZONE = @dead_zone@  # N
brake_lag           |BRAKE_ON, BRAKE_OFF = @brake_on@, @brake_off@  # s
let_go              |LET_GO = @let_go@  # N
friction            |STATIC, KINETIC, VISCOUS = @static@, @kinetic@, @viscous@  # N, N, N s/rad
finger              |FINGER_MASS, FINGER_STIFFNESS, FINGER_DAMPING = @finger_mass@, @finger_stiffness@, @finger_damping@  # kg, N/m, N s/m
bottoms             |FINGER_LENGTH = @finger_length@  # m
gravity             |WEIGHT = @weight@  # m g r / L, N
motor_lag           |MOTOR = @motor_at@  # place of its force in the state
brake_lag           |LEVEL = @level_at@  # place of the brake's level in the state
                    |# Zones, lowest first: from, rad; stiffness, N/rad; damping, N s/rad; force at theta = 0, N, infinite for all there is.
                    |ZONES = [@zones@]
"#;

/// The signals of time.
pub(super) const INPUTS: &str = r#"
                    |
                    |
                    |@input@
pull                |
pull                |
pull                |@pull_input@
"#;

/// What is asked of the actuators on each side.
pub(super) const ACTUATORS: &str = r#"
                    |
                    |
                    |def clip(value, most):
                    |    return min(max(value, -most), most)
                    |
                    |
                    |def zone(theta, side):
                    |    """Number of the zone just above (side 1) or just below (side -1) an angle."""
                    |    return sum(theta >= row[0] if side > 0 else theta > row[0] for row in ZONES[1:])
                    |
                    |
                    |def demanded(theta, omega, number):
                    |    """The force that a zone asks for, N; above 0 it resists a push into the object."""
                    |    _, stiffness, damping, force = ZONES[number]
                    |    return stiffness * theta + damping * omega + force
                    |
                    |
                    |def actuators(theta, omega, side, number):
                    |    """What is asked of the actuators if the lever moves to a side: the motor's force, the brake's force, the brake's level, N."""
active              |    return -clip(demanded(theta, omega, number), MOTOR_MAX), 0.0, 0.0
hybrid              |    if side < 0:
hybrid              |        return -clip(demanded(theta, omega, number), MOTOR_MAX), 0.0, 0.0
passive signed      |    if side < 0:
passive signed      |        return 0.0, 0.0, 0.0
brake signed        |    return 0.0, -clip(demanded(theta, omega, number), BRAKE_MAX), 0.0
brake coulomb       |    # A brake that lets the lever slip backwards follows the spring alone; it cannot push.
brake coulomb       |    asked = demanded(theta, omega if side > 0 else 0.0, number)
brake coulomb       |    return 0.0, 0.0, min(max(abs(asked) if math.isinf(asked) else asked - DEAD_ZONE, 0.0), BRAKE_MAX)
"#;

/// Forces, rates, and the rules from one way of moving to the next.
pub(super) const MOTION: &str = r#"
                    |
                    |
                    |@dataclass
                    |class Region:
                    |    """Which equations hold."""
                    |
                    |    inside: float  # a time within the stretch of the input that holds, s
                    |    side: int = 0  # 1: the lever moves forward, -1: backward, 0: it rests
                    |    zone: int = 0  # of a lever that moves
                    |    stop: int = 0  # the stop that a lever at rest leans on: 1 the upper, -1 the lower
bottoms             |    contact: int = 0  # 1: the finger's tissue is fully pressed, -1: fully stretched
let_go              |    held: bool = False  # at rest, the user's force is above the brake's threshold
hybrid brake_lag    |    motor_holds: bool = False  # at rest, the motor that is asked to hold pushes towards -theta
shares              |    share: float = 0.0  # at rest, force that the motor is spared per newton that the brake holds
                    |
                    |
                    |def force(t, y, side, region, dry):
                    |    """Net force on the lever's end if it moves to a side against this dry friction, N; above 0 into the object."""
                    |    theta, omega = y[0], y[1]
                    |    number = region.zone if region.side else zone(theta, side)
                    |    motor, brake, level = actuators(theta, omega, side, number)
hybrid brake_lag    |    if region.motor_holds and side > 0:  # the motor holds until the lever really moves
hybrid brake_lag    |        motor = actuators(theta, omega, -1, zone(theta, -1))[0]
motor_lag           |    motor = y[MOTOR]
brake_lag           |    level = y[LEVEL]
!finger             |    total = external(t, region.inside) + motor + brake
finger              |    total = tip(t, y, region) + motor + brake
friction            |    total -= VISCOUS * omega
gravity             |    total += WEIGHT * math.sin(theta)
terms               |    total += @term_constant@ + @term_rad@ * theta + @term_rad_s@ * omega
pull                |    total += @term_input@ * displacement(t, region.inside)
                    |    return total - side * (level + dry)
finger              |
finger              |
finger              |def tip(t, y, region):
finger              |    """Force of the finger on the lever's end, N: its tissue's, or the user's where that is rigid."""
bottoms             |    if region.contact:
bottoms             |        return external(t, region.inside)
finger              |    return FINGER_STIFFNESS * y[2] + FINGER_DAMPING * y[3]
                    |
                    |
                    |def departing(t, y, side, region):
                    |    """Net force on a lever at rest if it were to move to a side, N."""
friction            |    return force(t, y, side, region, STATIC)
!friction           |    return force(t, y, side, region, 0.0)
                    |
                    |
                    |def acceleration(t, y, region):
                    |    """Of the lever, rad/s^2."""
                    |    if not region.side:
                    |        return 0.0
                    |    moved = MASS
bottoms consistent  |    if region.contact:
bottoms consistent  |        moved += FINGER_MASS
friction            |    return force(t, y, region.side, region, KINETIC) / (moved * LEVER)
!friction           |    return force(t, y, region.side, region, 0.0) / (moved * LEVER)
                    |
                    |
                    |def slope(t, y, region):
                    |    """The state's rate."""
                    |    rate = np.zeros(len(y))
                    |    rate[0] = y[1] if region.side else 0.0
                    |    rate[1] = acceleration(t, y, region)
bottoms             |    if not region.contact:
bottoms             |        rate[2] = y[3]
bottoms             |        rate[3] = (external(t, region.inside) - tip(t, y, region)) / FINGER_MASS
bottoms consistent  |        rate[3] -= LEVER * rate[1]
finger !bottoms     |    rate[2] = y[3]
finger !bottoms     |    rate[3] = (external(t, region.inside) - tip(t, y, region)) / FINGER_MASS
finger !bottoms consistent|    rate[3] -= LEVER * rate[1]
lags                |    side = 1 if region.side > 0 else -1
lags let_go         |    if region.held:
lags let_go         |        side = 1
lags                |    motor, _, level = actuators(y[0], y[1], side, region.zone if region.side else zone(y[0], side))
shares              |    motor += region.share * departing(t, y, -1, region)
motor_lag           |    rate[MOTOR] = (motor - y[MOTOR]) / MOTOR_LAG
brake_lag hybrid    |    rate[LEVEL] = (level - y[LEVEL]) / (BRAKE_ON if side > 0 else BRAKE_OFF)
brake_lag passive   |    rate[LEVEL] = (level - y[LEVEL]) / BRAKE_ON
                    |    return rate
                    |
                    |
                    |LEAST = 1e-12  # N: less moves no lever at rest, for a function that stays at 0 counts as crossed
                    |
                    |
                    |def exits(region):
                    |    """What ends a region: functions that are not below 0 while it holds."""
                    |    side, ends = region.side, {}
                    |    if side:
                    |        ends["reversal"] = lambda t, y: side * y[1]
zones               |        number = region.zone + (side > 0)
stops               |        stop = STOPS[side > 0]
zones !stops        |        if 0 < number < len(ZONES):
zones stops         |        # An edge on the stop or beyond it is never crossed.
zones stops         |        if 0 < number < len(ZONES) and (ZONES[number][0] - stop) * side < 0:
zones               |            ends["zone"] = lambda t, y: side * (ZONES[number][0] - y[0])
stops               |        ends["stop"] = lambda t, y: side * (stop - y[0])
                    |    else:
                    |        if region.stop != 1:
                    |            ends["forward"] = lambda t, y: LEAST - departing(t, y, 1, region)
let_go              |        if region.stop != -1 and not region.held:
!let_go             |        if region.stop != -1:
                    |            ends["backward"] = lambda t, y: LEAST + departing(t, y, -1, region)
let_go              |        sign = 1 if region.held else -1
let_go              |        ends["let go"] = lambda t, y: sign * (external(t, region.inside) - LET_GO)
bottoms             |    if region.contact:
bottoms             |        ends["lifts off"] = lambda t, y: press(t, y, region)
bottoms             |    else:
bottoms             |        ends["pressed"] = lambda t, y: FINGER_LENGTH - y[2]
bottoms             |        ends["stretched"] = lambda t, y: FINGER_LENGTH + y[2]
                    |    return ends
bottoms             |
bottoms             |
bottoms             |def press(t, y, region):
bottoms             |    """Force between the finger and its rigid stop, N."""
bottoms             |    through = external(t, region.inside)
bottoms consistent  |    through -= FINGER_MASS * LEVER * acceleration(t, y, region)
bottoms             |    return region.contact * through - FINGER_STIFFNESS * FINGER_LENGTH
                    |
                    |
                    |def resting(t, y, inside@contact_argument@@held_argument@):
                    |    """The region of rest at an angle."""
                    |    region = Region(inside)
bottoms             |    region.contact = contact
stops               |    region.stop = 1 if y[0] >= STOPS[1] else -1 if y[0] <= STOPS[0] else 0
let_go              |    region.held = external(t, inside) >= LET_GO if held is None else held
hybrid lags let_go  |    if region.held:
hybrid lags let_go  |        return region
hybrid lags         |    asked = -actuators(y[0], 0.0, -1, zone(y[0], -1))[0]
hybrid brake_lag    |    region.motor_holds = asked > 0
shares              |    cone = departing(t, y, -1, region) - departing(t, y, 1, region)
shares              |    region.share = asked / cone if cone > 0 and asked > 0 else 0.0
                    |    return region
                    |
                    |
                    |def moving(y, side, inside@contact_argument@):
                    |    """The region of motion to a side."""
                    |    region = Region(inside, side, zone(y[0], side))
bottoms             |    region.contact = contact
                    |    return region
                    |
                    |
                    |def settled(t, y, inside@contact_argument@@held_argument@):
                    |    """The region that holds in a state."""
                    |    if y[1]:
                    |        region = moving(y, 1 if y[1] > 0 else -1, inside@contact@)
                    |    else:
                    |        region = resting(t, y, inside@contact@@held@)
let_go              |        if region.stop != -1 and not region.held and departing(t, y, -1, region) < -LEAST:
!let_go             |        if region.stop != -1 and departing(t, y, -1, region) < -LEAST:
                    |            region = moving(y, -1, inside@contact@)
                    |        elif region.stop != 1 and departing(t, y, 1, region) > LEAST:
                    |            region = moving(y, 1, inside@contact@)
bottoms             |    if contact and press(t, y, region) < 0:  # a rigid stop that would have to pull
bottoms             |        return settled(t, y, inside, 0@held@)
                    |    return region
bottoms             |
bottoms             |
bottoms             |def pressed(y):
bottoms             |    """Sets the finger on its rigid stop, inelastically; which one it is."""
bottoms             |    contact = 1 if y[2] > 0 else -1
bottoms             |    y[2] = contact * FINGER_LENGTH
bottoms consistent  |    y[1] += FINGER_MASS / (FINGER_MASS + MASS) * y[3] / LEVER
bottoms             |    y[3] = 0.0
bottoms             |    return contact
                    |
                    |
                    |def after(kind, t, y, region):
                    |    """Carries an event out on the state; the region that holds then."""
                    |    side, inside = region.side, region.inside
bottoms             |    contact = region.contact
                    |    if kind in ("forward", "backward"):
                    |        return moving(y, 1 if kind == "forward" else -1, inside@contact@)
                    |    if kind == "reversal":
                    |        y[1] = 0.0
zones               |    elif kind == "zone":
zones               |        y[0] = ZONES[region.zone + (side > 0)][0]
zones               |        rest = resting(t, y, inside@contact@)
zones               |        up, down = departing(t, y, 1, rest), departing(t, y, -1, rest)
zones               |        # Where both sides push back to the edge, a bounce of less than 2e-10 rad is rest.
zones               |        if up < 0 < down and y[1] ** 2 * MASS * LEVER < 4e-10 * min(down, -up):
zones               |            y[1] = 0.0
zones               |            return rest
zones               |        return moving(y, side, inside@contact@)
stops               |    elif kind == "stop":  # the lever stops dead
stops               |        y[0] = STOPS[side > 0]
stops consistent    |        speed = LEVER * y[1]
stops               |        y[1] = 0.0
stops consistent bottoms|        if contact == side or (not contact and y[2] * side >= FINGER_LENGTH * (1 - 1e-9)):
stops consistent bottoms|            contact = pressed(y)
stops consistent bottoms|            y[1] = 0.0
stops consistent bottoms|        else:  # the finger keeps its own velocity
stops consistent bottoms|            y[3] += speed
stops consistent bottoms|            contact = 0
stops consistent !bottoms|        y[3] += speed  # the finger keeps its own velocity
let_go              |    elif kind == "let go":
let_go              |        return settled(t, y, inside@contact@, not region.held)
bottoms             |    elif kind in ("pressed", "stretched"):
bottoms             |        contact = pressed(y)
bottoms             |        if region.stop and y[1] * region.stop > 0:
bottoms             |            y[1] = 0.0
bottoms             |    elif kind == "lifts off":
bottoms let_go      |        held = None if side else region.held
bottoms             |        return settled(t, y, inside, 0@held@)
                    |    return settled(t, y, inside@contact@)
                    |
                    |
                    |def first_state():
                    |    """Angle, velocity, the finger's and the actuators' own entries: these start at rest."""
                    |    y = np.zeros(@entries@)
                    |    y[0], y[1] = START
                    |    return y
"#;

/// When samples are taken, and where a stretch of time ends in which the input is one line or sine.
pub(super) const SAMPLES: &str = r#"
                    |
                    |
                    |def stretch_end(t):
                    |    """Where the stretch after t ends in which the input is one line or one sine, s."""
!pull               |    return min(external_end(t), DURATION)
pull                |    return min(external_end(t), displacement_end(t), DURATION)
                    |
                    |
                    |def sample_times():
                    |    """0 to DURATION in steps of STEP, s; a last step may be shorter."""
                    |    times = STEP * np.arange(math.floor(DURATION / STEP * (1 + 1e-9)) + 1)
                    |    return times if DURATION - times[-1] <= 1e-9 * DURATION else np.append(times, DURATION)
"#;

/// Writes what `simulate` returns.
pub(super) const WRITE: &str = r#"
                    |
                    |
                    |if __name__ == "__main__":
                    |    times, states = simulate()
                    |    rows = np.column_stack([times, states[:, :2]])
                    |    out = sys.argv[1] if len(sys.argv) > 1 else sys.stdout
                    |    np.savetxt(out, rows, fmt="%.17g", delimiter=",", header="t_s,theta_rad,theta_dot_rad_s", comments="")
"#;
