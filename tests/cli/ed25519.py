# SPDX-License-Identifier: Apache-2.0
"""Ed25519 from the formulas of RFC 8032 section 5.1, slow and plain: a second implementation beside libsodium."""
import hashlib

P = 2**255 - 19
L = 2**252 + 27742317777372353535851937790883648493
D = -121665 * pow(121666, -1, P) % P
SQRT_M1 = pow(2, (P - 1) // 4, P)


def _recover_x(y, sign):
    """x of the point with this y: x² = (y² - 1) / (d y² + 1); None where there is none."""
    if y >= P:
        return None
    square = (y * y - 1) * pow(D * y * y + 1, -1, P) % P
    x = pow(square, (P + 3) // 8, P)
    if (x * x - square) % P:
        x = x * SQRT_M1 % P
    if (x * x - square) % P or (x == 0 and sign):
        return None
    return P - x if x % 2 != sign else x


_BASE_Y = 4 * pow(5, -1, P) % P
BASE = (_recover_x(_BASE_Y, 0), _BASE_Y)


def _add(a, b):
    """The complete addition law of the twisted Edwards curve -x² + y² = 1 + d x² y²."""
    (x1, y1), (x2, y2) = a, b
    k = D * x1 * x2 * y1 * y2 % P
    return ((x1 * y2 + x2 * y1) * pow(1 + k, -1, P) % P, (y1 * y2 + x1 * x2) * pow(1 - k, -1, P) % P)


def _times(factor, point):
    result = (0, 1)
    while factor:
        if factor & 1:
            result = _add(result, point)
        point = _add(point, point)
        factor >>= 1
    return result


def _encode(point):
    return (point[1] | (point[0] & 1) << 255).to_bytes(32, "little")


def _decode(data):
    number = int.from_bytes(data, "little")
    y = number & ((1 << 255) - 1)
    x = _recover_x(y, number >> 255)
    return None if x is None else (x, y)


def _hash(*parts):
    return int.from_bytes(hashlib.sha512(b"".join(parts)).digest(), "little")


def _secret_scalar(seed):
    digest = hashlib.sha512(seed).digest()
    scalar = int.from_bytes(digest[:32], "little")
    return (scalar & ~7 & ((1 << 254) - 1)) | 1 << 254, digest[32:]


def public_key(seed):
    return _encode(_times(_secret_scalar(seed)[0], BASE))


def sign(seed, message):
    scalar, prefix = _secret_scalar(seed)
    public = public_key(seed)
    r = _hash(prefix, message) % L
    point = _encode(_times(r, BASE))
    s = (r + _hash(point, public, message) * scalar) % L
    return point + s.to_bytes(32, "little")


def verify(public, message, signature):
    a, r = _decode(public), _decode(signature[:32])
    s = int.from_bytes(signature[32:], "little")
    if a is None or r is None or s >= L or len(signature) != 64:
        return False
    return _times(s, BASE) == _add(r, _times(_hash(signature[:32], public, message) % L, a))
