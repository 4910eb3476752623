"""A controller of a phase-decoupled drive: speed regulator, initial angle line, and a search for the least Σ|i|.

The same algorithm is in ../numba, ../c and ../rust, operation by operation, and gives the same commands bit for bit.
It meets every required check in all fixed scenarios; what the search finds beyond them, and what the advisory ripple
checks say, `drivegate check controller.py:Controller` reports.
"""

from drivegate import Command, Nameplate, Sense

DEGREE = 0.017453292519943295

INTERVAL = 57.5  # rad at base speed: the search decides once in this time
PATIENCE = 4.6  # rad at base speed: a speed that stays behind for so long has lost its torque
CALM = 0.003  # of base speed
CREEPING = 0.0014  # of base speed
MARGIN = 0.02  # of base speed: how far above it the advance begins
FIRST_STEP = 2.0 * DEGREE
LAST_STEP = 0.7 * DEGREE
HIGHEST = 24.0 * DEGREE
NOWHERE = -90.0 * DEGREE

WAITING, SEARCHING, RECOVERING, RESTING = range(4)


class Controller:
    """Regulates the speed, and moves the advance angle to where the sum of the phase currents is least."""

    def reset(self, nameplate: Nameplate) -> None:
        """Prepare for a run, and forget all earlier ones."""
        self.limit = nameplate.current_limit
        self.base_speed = nameplate.base_speed
        self.nominal_voltage = nameplate.half_supply_voltage
        self.period = nameplate.control_period
        frequency = nameplate.pole_pairs * nameplate.base_speed
        bandwidth = frequency / 7.2
        self.interval = INTERVAL / frequency
        self.patience = PATIENCE / frequency
        self.calm = CALM * nameplate.base_speed
        self.creeping = CREEPING * nameplate.base_speed
        self.advance_begins = nameplate.base_speed + MARGIN * nameplate.base_speed
        self.line_start = nameplate.advance_start
        self.line_slope = nameplate.advance_slope
        self.gain = bandwidth * nameplate.inertia / (nameplate.conducting_phases * nameplate.emf_constant)
        self.integral_step = 0.1875 * bandwidth * self.gain * nameplate.control_period
        self.integral = 0.0
        self.speed_reference = -1.0
        self.advancing = 0
        self.strained = 0
        self.speed_mark = 0.0
        self.step_size = 0.0
        self.moves = 0
        self.escapes = 0
        self.offset = 0.0
        self.best_offset = 0.0
        self.best_current = 0.0
        self.best_integral = 0.0
        self.begin_anew()

    def step(self, sense: Sense) -> Command:
        """Answer for one control period."""
        error = sense.speed_reference - sense.speed
        reference = self.regulate(error)
        power = sense.half_supply_voltage * sense.current_magnitude_sum
        if sense.speed_reference != self.speed_reference:
            self.speed_reference = sense.speed_reference
            self.offset = 0.0
            self.begin_anew()
        if sense.speed < self.base_speed:
            self.advancing = 0
        elif sense.speed >= self.advance_begins:
            self.advancing = 1
        if self.advancing == 0:
            return Command(reference, 0.0, power)

        self.worst_error = max(self.worst_error, abs(error))
        self.current_sum += sense.current_magnitude_sum
        self.steps += 1
        if self.has_lost_torque(error, reference, sense.speed):
            self.regain_torque()
        elif self.steps * self.period >= self.interval:
            self.end_interval()
        return Command(reference, self.advance_angle(sense.speed, sense.half_supply_voltage), power)

    def regulate(self, error: float) -> float:
        """Return the current reference: a PI regulator whose integral waits while the output is limited."""
        integral = self.integral + self.integral_step * error
        reference = self.gain * error + integral
        output = min(max(reference, 0.0), self.limit)
        if output == reference:
            self.integral = integral
        return output

    def advance_angle(self, speed: float, voltage: float) -> float:
        """Return the initial line over speed, at the same EMF over supply, plus the search's offset."""
        if voltage > 1.0:
            speed = speed * self.nominal_voltage / voltage
        line = self.line_start + self.line_slope * (speed - self.base_speed)
        return min(max(line + self.offset, 0.0), 90.0 * DEGREE)

    def begin_anew(self) -> None:
        """Begin a new search, with nothing known of the edge where the torque is lost."""
        self.lost_offset = NOWHERE
        self.enter(WAITING)
        self.last_current = 0.0

    def enter(self, phase: int) -> None:
        """Enter a phase of the search."""
        self.phase = phase
        self.intervals = 0
        self.begin_interval()

    def begin_interval(self) -> None:
        """Begin to take the mean of Σ|i|."""
        self.steps = 0
        self.current_sum = 0.0
        self.worst_error = 0.0

    def end_interval(self) -> None:
        """Decide on the angle from the mean of Σ|i| over the interval."""
        current = self.current_sum / self.steps
        error = self.worst_error
        change = abs(current - self.last_current)
        self.intervals += 1
        self.begin_interval()
        if self.phase == WAITING:
            self.last_current = current
            if self.intervals >= 2 and error <= self.calm and change <= 0.004 * current:
                self.keep(current)
                self.moves = 0
                self.step_size = -FIRST_STEP
                self.try_next()
        elif self.phase == SEARCHING:
            if self.intervals >= 2:
                self.judge(current, error)
        elif self.phase == RECOVERING:
            if error <= self.calm:
                self.try_next()
            elif self.intervals >= 3:
                # The best angle so far keeps the torque for a while only.
                self.lost_offset = self.best_offset
                self.best_offset = self.best_offset + FIRST_STEP
                self.offset = self.best_offset
                self.unwind()
                self.enter(RECOVERING)
        elif self.intervals < 3:
            self.last_current = current
        elif abs(current - self.best_current) > 0.05 * self.best_current:
            self.begin_anew()
        elif self.intervals < 25 and change > 0.003 * self.last_current:
            # Restless, so too near to the edge.
            self.offset = self.offset + 0.5 * DEGREE
            self.enter(RESTING)

    def judge(self, current: float, error: float) -> None:
        """Keep the angle that was tried if Σ|i| is less there and the regulator does not creep up."""
        creeps = error >= self.creeping and self.integral >= 1.02 * self.best_integral
        if current < 0.999 * self.best_current and not creeps:
            self.keep(current)
            self.moves += 1
        elif self.moves == 0 and self.step_size == -FIRST_STEP:
            self.step_size = 0.5 * FIRST_STEP
        else:
            self.step_size = 0.5 * self.step_size
        self.try_next()

    def keep(self, current: float) -> None:
        """Note the present angle as the best one."""
        self.best_current = current
        self.best_offset = self.offset
        self.best_integral = self.integral

    def try_next(self) -> None:
        """Go one step on from the best angle, by half a step where more loses the torque; or rest there."""
        following = self.best_offset + self.step_size
        if following <= self.lost_offset:
            self.step_size = 0.5 * self.step_size
            following = self.best_offset + self.step_size
        if abs(self.step_size) < LAST_STEP or following <= self.lost_offset:
            self.offset = self.best_offset
            self.escapes = 0
            self.enter(RESTING)
        else:
            self.offset = following
            self.enter(SEARCHING)

    def has_lost_torque(self, error: float, reference: float, speed: float) -> bool:
        """Return whether the speed has stayed behind for some time, or does not rise at the current limit."""
        settled = self.phase == SEARCHING or self.phase == RESTING
        strained = error > self.calm if settled else reference >= self.limit
        self.strained = self.strained + 1 if strained else 0
        if self.strained == 1:
            self.speed_mark = speed
        if self.strained * self.period < self.patience:
            return False
        self.strained = 0
        return settled or speed <= self.speed_mark

    def regain_torque(self) -> None:
        """Go back from the edge of what the angle allows."""
        if self.phase == SEARCHING:
            self.lost_offset = self.offset
            self.step_size = 0.5 * self.step_size
            self.offset = self.best_offset + FIRST_STEP
            self.unwind()
            self.enter(RECOVERING)
        elif self.phase == RESTING and self.intervals < 3 and self.escapes < 2:
            self.escapes += 1
            self.offset = self.offset + 0.5 * DEGREE
            self.unwind()
            self.enter(RESTING)
        else:
            # The load has risen, or the initial line is too low.
            within = self.offset >= 0.0 and self.offset < HIGHEST
            self.offset = self.offset + FIRST_STEP if within else 0.0
            self.enter(WAITING)

    def unwind(self) -> None:
        """Take back what the integral has wound up in vain."""
        self.integral = min(self.integral, 1.02 * self.best_integral)
