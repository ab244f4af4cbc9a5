# SPDX-License-Identifier: Apache-2.0
"""A drive file of a vehicle that rests for 40 s and then drives an eight over a hill, course and attitude by closed forms.

What a unit on it reads follows from differences of its course in axes fixed to the Earth and Newton's law there: no equation is that of a
filter in the local level. WGS 84: NIMA TR8350.2, third edition, tables 3.1, 3.3, 3.4, eq. 4-1 (gravity on the ellipsoid, from that
at the equator and the pole) and 4-3 (with height). `tools/prove/nav-peer` checks itself by it.
"""
import math

import numpy as np

A_M, B_M, EARTH_RPS = 6378137.0, 6356752.3142, 7.292115e-5
EQUATOR_MPS2, POLE_MPS2 = 9.7803253359, 9.8321849378
FLATTENING, M_RATIO = 1 / 298.257223563, 0.00344978650684

LAT, LON, HEIGHT_M = math.radians(47.0), math.radians(8.0), 400.0
REST_S, START_S = 40.0, 20.0
LEVER_M = np.array([0.4, -1.1, 0.3])
HEADING_DEG, PITCH_DEG = 5.0, -7.0


def phase(t):
    """Phase of the eight and its speed: the vehicle starts gently."""
    tau = np.maximum(t - REST_S, 0.0) / START_S
    top = 0.035
    return top * START_S * (tau - 0.5 * math.sqrt(math.pi) * np.vectorize(math.erf)(tau)), top * -np.expm1(-(tau**2))


def radii(lat):
    """Radii of curvature in the meridian and in the prime vertical, m, from both half axes."""
    root = np.sqrt((A_M * np.cos(lat)) ** 2 + (B_M * np.sin(lat)) ** 2)
    return (A_M * B_M) ** 2 / root**3, A_M**2 / root


def gravity(lat, h):
    c2, s2 = np.cos(lat) ** 2, np.sin(lat) ** 2
    surface = (A_M * EQUATOR_MPS2 * c2 + B_M * POLE_MPS2 * s2) / np.sqrt(A_M**2 * c2 + B_M**2 * s2)
    return surface * (1 - 2 / A_M * (1 + FLATTENING + M_RATIO - 2 * FLATTENING * s2) * h + 3 * (h / A_M) ** 2)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def course(t):
    """Place (latitude, longitude, height), velocity east, north, up, axes of the vehicle (right, forward, up) in the local level."""
    s, ds = phase(t)
    lat, lon, h = LAT + 300 / A_M * np.sin(s), LON + 150 / (A_M * math.cos(LAT)) * np.sin(2 * s), HEIGHT_M + 5 * np.sin(3 * s)
    meridian, vertical = radii(lat)
    along = np.column_stack([300 / (A_M * math.cos(LAT)) * np.cos(2 * s) * (vertical + h) * np.cos(lat),
                             300 / A_M * np.cos(s) * (meridian + h), 15 * np.cos(3 * s)])
    forward = unit(along)
    right = unit(np.cross(forward, [0, 0, 1]))
    return np.column_stack([lat, lon, h]), along * ds[:, None], np.stack([right, forward, np.cross(right, forward)], axis=2)


def in_earth(place):
    """Place in axes fixed to the Earth, m, and the axes east, north, up there."""
    lat, lon, h = place.T
    _, vertical = radii(lat)
    zero, sl, cl, sp, cp = np.zeros_like(lat), np.sin(lon), np.cos(lon), np.sin(lat), np.cos(lat)
    axes = np.stack([np.column_stack([-sl, cl, zero]), np.column_stack([-sp * cl, -sp * sl, cp]), np.column_stack([cp * cl, cp * sl, sp])], axis=2)
    return np.column_stack([(vertical + h) * cp * cl, (vertical + h) * cp * sl, (vertical * (B_M / A_M) ** 2 + h) * sp]), axes


def readings(t, d=0.02):
    """Rates in rad/s and specific forces in m/s^2 in the vehicle's axes, by differences over d."""
    moments = []
    for moment in (t - d, t, t + d):
        place, _, c = course(moment)
        r, level = in_earth(place)
        moments.append((r, level @ c))
    (r0, body0), (r, body), (r1, body1) = moments
    turned = body0.transpose(0, 2, 1) @ body1
    sine = 0.5 * np.column_stack([turned[:, 2, 1] - turned[:, 1, 2], turned[:, 0, 2] - turned[:, 2, 0], turned[:, 1, 0] - turned[:, 0, 1]])
    size = np.maximum(np.linalg.norm(sine, axis=1, keepdims=True), 1e-300)
    earth = np.array([0.0, 0.0, EARTH_RPS])
    rates = sine * np.arcsin(size) / size / (2 * d) + np.einsum("nji,j->ni", body, earth)
    place = course(t)[0]
    up = in_earth(place)[1][:, :, 2]
    force = (r1 - 2 * r + r0) / d**2 + 2 * np.cross(earth, (r1 - r0) / (2 * d)) + up * gravity(place[:, 0], place[:, 2])[:, None]
    return rates, np.einsum("nji,nj->ni", body, force)


def antenna(t, d=0.01):
    """Place and velocity of the antenna: those of the unit and what the lever arm adds."""
    place, v, c = course(t)
    before, after = (in_earth(course(moment)[0])[1] @ course(moment)[2] @ LEVER_M for moment in (t - d, t + d))
    arm, (meridian, vertical) = c @ LEVER_M, radii(place[:, 0])
    shift = np.column_stack([arm[:, 1] / (meridian + place[:, 2]), arm[:, 0] / ((vertical + place[:, 2]) * np.cos(place[:, 0])), arm[:, 2]])
    return place + shift, v + np.einsum("nji,nj->ni", in_earth(place)[1], (after - before) / (2 * d))


def unit_axes():
    """The unit's right, forward, up in the vehicle: its nose points to the right by the heading and up by the pitch."""
    heading, pitch = math.radians(HEADING_DEG), math.radians(PITCH_DEG)
    right = np.array([math.cos(heading), -math.sin(heading), 0.0])
    forward = np.array([math.sin(heading) * math.cos(pitch), math.cos(heading) * math.cos(pitch), math.sin(pitch)])
    return np.array([right, forward, np.cross(right, forward)])


def write(folder, gyro_bias_rps, accel_bias_mps2, seconds=200):
    """The drive file in the folder. Biases are given in the vehicle's axes; the unit's x points backwards, its y to the right."""
    t = np.arange(0, seconds, 0.01)
    turned = [(of + bias) @ unit_axes().T for of, bias in zip(readings(t), (gyro_bias_rps, accel_bias_mps2))]
    own = [np.column_stack([-of[:, 1], of[:, 0], of[:, 2]]) for of in turned]
    np.savetxt(folder / "imu.csv", np.column_stack([t, *own]), fmt="%.12g", delimiter=",", comments="",
               header="t_s,gx_rps,gy_rps,gz_rps,ax_mps2,ay_mps2,az_mps2")
    t = np.arange(0.25, seconds - 0.25, 0.25)
    place, v = antenna(t)
    place[:, :2] = np.degrees(place[:, :2])
    np.savetxt(folder / "fixes.csv", np.column_stack([t, place, np.full((len(t), 3), 0.02), v[:, [1, 0, 2]], np.full((len(t), 3), 0.05)]),
               fmt="%.14g", delimiter=",", comments="",
               header="t_s,latitude_deg,longitude_deg,height_m,sd_north_m,sd_east_m,sd_up_m,v_north_mps,v_east_mps,v_up_mps,"
                      "sd_v_north_mps,sd_v_east_mps,sd_v_up_mps")
    path = folder / "drive.toml"
    path.write_text(f'name = "made up"\nlever_arm_m = {LEVER_M.tolist()}\n[imu]\nfile = "imu.csv"\naxes = ["y", "-x", "z"]\n'
                    f'mounting_deg = [{HEADING_DEG}, {PITCH_DEG}, 0.0]\n[gnss]\nfile = "fixes.csv"\nevery = 4\n', encoding="utf-8")
    return path
