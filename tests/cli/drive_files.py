# SPDX-License-Identifier: Apache-2.0
"""A recorded drive as text, from plain formulas: at rest, then straight on."""
import datetime
import math
import random

ORIGIN = (math.radians(51.0), math.radians(-114.0), 1000.0)
REST_S, SPEED_UP_S, SPEED = 30, 5, 10.0


def radii(latitude):
    w2 = 1 - 0.00669437999014 * math.sin(latitude) ** 2
    normal = 6378137.0 / math.sqrt(w2)
    return normal * (1 - 0.00669437999014) / w2, normal


def gravity(latitude, height):
    """Somigliana and free air, to 1e-5 m/s2."""
    s2 = math.sin(latitude) ** 2
    at_sea = 9.7803253359 * (1 + 0.00193185265241 * s2) / math.sqrt(1 - 0.00669437999014 * s2)
    return at_sea - 3.086e-6 * height


def speed_and_way(t):
    """Of a vehicle that speeds up evenly."""
    t = max(0.0, t - REST_S)
    if t < SPEED_UP_S:
        return SPEED / SPEED_UP_S * t, 0.5 * SPEED / SPEED_UP_S * t * t
    return SPEED, SPEED * (t - 0.5 * SPEED_UP_S)


def write_drive(folder, seconds=200, rate_hz=50, gyro_noise_dps=0.02, temp_c=None, seed=1, start_s=0):
    """drive.toml, imu.csv, fixes.csv: northwards along the meridian, the unit's axes forward, left, up. Returns the drive file's path."""
    noise = random.Random(seed)
    earth = 7.292115e-5
    meridian, normal = radii(ORIGIN[0])
    imu = ["t_s,ax_mps2,ay_mps2,az_mps2,gx_dps,gy_dps,gz_dps" + (",temp_c" if temp_c else "")]
    fixes = ["t_s,latitude_deg,longitude_deg,height_m,sd_north_m,sd_east_m,sd_up_m,v_north_mps,v_east_mps,v_up_mps,"
             "sd_v_north_mps,sd_v_east_mps,sd_v_up_mps"]
    for i in range(1, seconds * rate_hz + 1):
        t = i / rate_hz
        speed, way = speed_and_way(t - 0.5 / rate_hz)
        latitude = ORIGIN[0] + way / (meridian + ORIGIN[2])
        ahead = SPEED / SPEED_UP_S if REST_S < t - 0.5 / rate_hz < REST_S + SPEED_UP_S else 0.0
        # The Earth turns under the vehicle: Coriolis pushes what goes north to the east, the way curves downwards.
        left = -2 * earth * math.sin(latitude) * speed * -1
        up = gravity(latitude, ORIGIN[2]) - speed * speed / meridian
        north_rate, up_rate = earth * math.cos(latitude), earth * math.sin(latitude)
        rates = [north_rate, speed / meridian, up_rate]  # about forward, left, up
        readings = [ahead, left, up] + [math.degrees(r) + noise.gauss(0, gyro_noise_dps) for r in rates]
        imu.append(f"{start_s + t:.4f}," + ",".join(f"{x:.9f}" for x in readings) + (f",{temp_c(t):.3f}" if temp_c else ""))
    for i in range(seconds + 1):
        speed, way = speed_and_way(i)
        latitude = math.degrees(ORIGIN[0] + way / (meridian + ORIGIN[2]))
        fixes.append(f"{start_s + i},{latitude:.12f},{math.degrees(ORIGIN[1])},{ORIGIN[2]},0.02,0.02,0.02,{speed},0,0,0.03,0.03,0.03")
    (folder / "imu.csv").write_text("\n".join(imu) + "\n", encoding="utf-8")
    (folder / "fixes.csv").write_text("\n".join(fixes) + "\n", encoding="utf-8")
    path = folder / "drive.toml"
    path.write_text('name = "straight"\n[imu]\nfile = "imu.csv"\naxes = ["-y", "x", "z"]\n[gnss]\nfile = "fixes.csv"\n', encoding="utf-8")
    return path


def write_rtklib(fixes, solution, first):
    """The same fixes as RTKLIB writes them; `first`: date and time of the first row."""
    header, *rows = fixes.read_text(encoding="utf-8").splitlines()
    begin = datetime.datetime.strptime(first, "%Y/%m/%d %H:%M:%S.%f")
    names = ("latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio vn(m/s) ve(m/s) vu(m/s) "
             "sdvn sdve sdvu sdvne sdveu sdvun")
    lines = ["% program   : RTKLIB", "%  GPST            " + names.replace(" ", "   ")]
    for i, row in enumerate(rows):
        cells = row.split(",")[1:]
        time = (begin + datetime.timedelta(seconds=i)).strftime("%Y/%m/%d %H:%M:%S.%f")[:-3]
        lines.append("  ".join([time, *cells[:3], "1", "20", *cells[3:6], "0", "0", "0", "0.0", "3.0", *cells[6:], "0", "0", "0"]))
    solution.write_text("\n".join(lines) + "\n", encoding="utf-8")
