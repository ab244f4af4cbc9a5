# SPDX-License-Identifier: Apache-2.0
"""An error-state Kalman filter of 15 states in the local level, loosely coupled, closed loop: what `soak nav` has, written anew from docs/nav.md and
the literature, without sight of the room nav. tools/prove/nav-peer compares them.

Equations: mechanization in the local level, east, north, up ([AH05] eq. 3.6, 3.7); WGS 84 ([NIMA] tables 3.1, 3.3, 3.4, eq. 4-1, 4-3);
Kalman filter ([AH05] eq. 3.12 to 3.15), update in Joseph form. Errors are truth less estimate; the attitude's, e, is a rotation
in the local level: C = exp(e x) C^. Axes of the vehicle are right, forward, up.

[AH05]  W. Abdel-Hamid, University of Calgary, UCGE 20207, 2005.
[NIMA]  Department of Defense World Geodetic System 1984, NIMA TR8350.2, third edition, 2000.
[MPU]   MPU-6000 and MPU-6050 Product Specification, PS-MPU-6000A-00, revision 3.4, InvenSense, 2013, sections 6.1 and 6.2.
"""
import math

import numpy as np

STANDARD_GRAVITY = 9.80665

# Noise of a consumer unit [MPU]: 0.005 deg/s/sqrt(Hz) and 0.4 mg/sqrt(Hz), tenfold for what shakes a unit on a car and for scale factors
# (3 % of a turn), which are not among the states.
GYRO_NOISE = 10 * math.radians(0.005)  # rad/s/sqrt(Hz)
ACCEL_NOISE = 10 * 0.4e-3 * STANDARD_GRAVITY  # m/s^2/sqrt(Hz)
# The biases walk at random, which is a Gauss-Markov process of long correlation time: 0.01 deg/s and 1 mg in 100 s, chosen here.
GYRO_WALK = math.radians(0.01) / 10  # rad/s/sqrt(s)
ACCEL_WALK = 1e-3 * STANDARD_GRAVITY / 10  # m/s^2/sqrt(s)
# A vehicle that does not slide, as docs/nav.md has it: speeds to the right and upwards, in the vehicle's axes.
SLIDE_SD_MPS = 0.2
SLIDE_PERIOD_S = 0.1

# ---- the Earth

A_M, F, EARTH_RPS = 6378137.0, 1 / 298.257223563, 7.292115e-5
E2 = F * (2 - F)
GM = 3.986004418e14
GAMMA_E, GAMMA_K = 9.7803253359, 0.00193185265241
M_RATIO = EARTH_RPS**2 * A_M**3 * (1 - F) / GM


def radii(lat):
    """Radii of curvature in the meridian and in the prime vertical, m."""
    w2 = 1 - E2 * math.sin(lat) ** 2
    return A_M * (1 - E2) / w2**1.5, A_M / math.sqrt(w2)


def gravity(lat, h):
    """Normal gravity, m/s^2: Somigliana at the ellipsoid, to second order in height [NIMA eq. 4-1, 4-3]."""
    s2 = math.sin(lat) ** 2
    surface = GAMMA_E * (1 + GAMMA_K * s2) / math.sqrt(1 - E2 * s2)
    return surface * (1 - 2 / A_M * (1 + F + M_RATIO - 2 * F * s2) * h + 3 * (h / A_M) ** 2)


def earth_rate(lat):
    return np.array([0.0, EARTH_RPS * math.cos(lat), EARTH_RPS * math.sin(lat)])


def metres(of, since):
    """East, north, up from one latitude, longitude, height to another near it, m."""
    meridian, vertical = radii(since[0])
    return np.array([(of[1] - since[1]) * (vertical + since[2]) * math.cos(since[0]), (of[0] - since[0]) * (meridian + since[2]), of[2] - since[2]])


# ---- rotations

def skew(a):
    x, y, z = a
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation(a):
    """exp(a x), Rodrigues' formula."""
    angle2 = float(a @ a)
    s = skew(a)
    if angle2 < 1e-12:
        return np.eye(3) + s + 0.5 * s @ s
    angle = math.sqrt(angle2)
    return np.eye(3) + math.sin(angle) / angle * s + (1 - math.cos(angle)) / angle2 * s @ s


# ---- the filter

R, V, E, BG, BA = (slice(k, k + 3) for k in range(0, 15, 3))


class Filter:
    """Place (latitude, longitude, height), velocity east, north, up, C from vehicle to local level, biases of gyros and accelerometers, covariance."""

    def __init__(self, place, v, c, bg, ba, p):
        self.place, self.v, self.c, self.bg, self.ba, self.p = place, v, c, bg, ba, p
        self.rate = np.zeros(3)  # of the last step, less its bias

    def copy(self):
        return Filter(*(part.copy() for part in (self.place, self.v, self.c, self.bg, self.ba, self.p)))

    def step(self, dt, rate, force):
        """[AH05] eq. 3.6 over dt with the mean rate and specific force of it, then the covariance."""
        lat, _, h = self.place
        meridian, vertical = radii(lat)
        east, north = vertical + h, meridian + h
        w, f = rate - self.bg, force - self.ba
        w_ie = earth_rate(lat)
        w_el = np.array([-self.v[1] / north, self.v[0] / east, self.v[0] * math.tan(lat) / east])
        g = gravity(lat, h)
        half = rotation(0.5 * dt * w)
        f_level = self.c @ half @ f
        v = self.v + dt * (f_level - skew(2 * w_ie + w_el) @ self.v - np.array([0.0, 0.0, g]))
        mean_v = 0.5 * (self.v + v)
        self._predict(dt, f_level, w_ie + w_el, 2 * w_ie + w_el, (north, east, math.tan(lat)), g)
        self.place = self.place + dt * np.array([mean_v[1] / north, mean_v[0] / (east * math.cos(lat)), mean_v[2]])
        self.v = v
        self.c = rotation(-dt * (w_ie + w_el)) @ self.c @ half @ half
        self.rate = w

    def _predict(self, dt, f_level, w_il, coriolis, earth, g):
        """P = Phi P Phi' + Q. F is [AH05] eq. 3.7; left out is what the Earth's rate and the curvature change with the place. With the errors above
        (de = 1 C df etc.): dr' = dv; dv' = -coriolis x dv - f x e - C dba + 2 g/a dh; e' = -w_il x e - dw_el - C dbg."""
        north, east, tan_lat = earth
        f = np.zeros((15, 15))
        f[R, V] = np.eye(3)
        f[5, 2] = 2 * g / A_M
        f[V, V] = -skew(coriolis)
        f[V, E] = -skew(f_level)
        f[V, BA] = f[E, BG] = -self.c
        f[E, E] = -skew(w_il)
        f[6, 4], f[7, 3], f[8, 3] = 1 / north, -1 / east, -tan_lat / east
        f *= dt
        phi = np.eye(15) + f + 0.5 * f @ f
        self.p = phi @ self.p @ phi.T
        self.p[DIAGONAL, DIAGONAL] += dt * DENSITY

    def update(self, residual, h, variance):
        """[AH05] eq. 3.13 to 3.15; the estimated errors go back into the mechanization."""
        s = h @ self.p @ h.T + np.diag(variance)
        k = np.linalg.solve(s, h @ self.p).T
        x = k @ residual
        left = np.eye(15) - k @ h
        self.p = left @ self.p @ left.T + (k * variance) @ k.T
        self.p = 0.5 * (self.p + self.p.T)
        meridian, vertical = radii(self.place[0])
        east, north = (vertical + self.place[2]) * math.cos(self.place[0]), meridian + self.place[2]
        self.place = self.place + np.array([x[1] / north, x[0] / east, x[2]])
        self.v = self.v + x[V]
        self.c = rotation(x[E]) @ self.c
        self.bg, self.ba = self.bg + x[BG], self.ba + x[BA]

    def update_fix(self, place, v, variance, lever_m):
        """The antenna is at r + C l and moves with v + C (w x l)."""
        arm, swing = self.c @ lever_m, self.c @ (skew(self.rate) @ lever_m)
        h = np.zeros((6, 15))
        h[0:3, R] = h[3:6, V] = np.eye(3)
        h[0:3, E], h[3:6, E] = -skew(arm), -skew(swing)
        h[3:6, BG] = self.c @ skew(lever_m)
        self.update(np.hstack([metres(place, self.place) - arm, v - self.v - swing]), h, variance)

    def update_no_slide(self):
        """C' v has no part to the right and none upwards."""
        h = np.zeros((3, 15))
        h[:, V], h[:, E] = self.c.T, self.c.T @ skew(self.v)
        self.update(-(self.c.T @ self.v)[[0, 2]], h[[0, 2]], np.full(2, SLIDE_SD_MPS**2))

    def antenna_error(self, truth, lever_m):
        return self.c @ lever_m - metres(truth, self.place)


DIAGONAL = np.arange(3, 15)
DENSITY = np.repeat([ACCEL_NOISE**2, GYRO_NOISE**2, GYRO_WALK**2, ACCEL_WALK**2], 3)
