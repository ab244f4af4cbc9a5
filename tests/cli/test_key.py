# SPDX-License-Identifier: Apache-2.0
"""soak key: keys, signing and verification of calibration files. What the signature must be is worked out here from
docs/blob-format.md alone, with an Ed25519 of our own (ed25519.py)."""
import hashlib
import os
import shutil
import stat
import struct
import subprocess
import unittest

import ed25519
from blob_reader import BlobError, Calibration, crc32c, read_sections
from soak_cli import ROOT, SoakTest, limit_file_size, long_test

GOLDEN = ROOT / "tests" / "data" / "golden"
# The key of RFC 8032 section 7.1, TEST 1: published, so nobody may ever trust it.
SEED = bytes.fromhex("9d61b19deffd5a60ba844af492ec2cc44449c5697b326919703bac031cae7f60")
PUBLIC = bytes.fromhex("d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a")
SIGNATURE_TYPE = 0x0040


def sealed(data):
    """The file with its size and CRC made right."""
    data = data[:12] + struct.pack("<I", len(data)) + data[16:]
    return data[:-4] + struct.pack("<I", crc32c(data[:-4]))


def expected_signed(unsigned, seed):
    """A signed file, put together as docs/blob-format.md says."""
    public = ed25519.public_key(seed)
    size = len(unsigned) + 80
    count = struct.unpack_from("<I", unsigned, 20)[0] + 1
    head = unsigned[:10] + struct.pack("<HIII", 1, size, 24, count)
    section = struct.pack("<HBBI", SIGNATURE_TYPE, 1, 0, 72) + hashlib.sha256(public).digest()[:8]
    body = head + unsigned[24:-4] + section
    body += ed25519.sign(seed, b"soak-signature-1" + body)
    return body + struct.pack("<I", crc32c(body))


class KeyTest(SoakTest):
    def setUp(self):
        super().setUp()
        self.unsigned = (GOLDEN / "fis.soakcal").read_bytes()
        self.file = self.write("SN.soakcal", self.unsigned)

    def key(self, name="lab.key", *arguments):
        self.soak("key", "new", "-o", self.folder / name, *arguments)
        return self.folder / name

    def known_key(self):
        """The published key, as key files."""
        secret = self.write("rfc.key", f"soak-secret-key-1\n{SEED.hex()}\ncomment RFC 8032 test 1\n")
        secret.chmod(0o600)
        self.write("rfc.key.pub", f"soak-public-key-1\n{PUBLIC.hex()}\ncomment RFC 8032 test 1\n")
        return secret

    def signed(self, key):
        self.soak("key", "sign", self.file, "--key", key)
        return self.file.read_bytes()

    def verify_status(self, data, *arguments):
        path = self.write("candidate.soakcal", bytes(data))
        done = subprocess.run(self.command("key", "verify", path, *arguments), capture_output=True, timeout=60, check=False)
        return done.returncode


class OwnEd25519(unittest.TestCase):
    """RFC 8032 section 7.1: the tests' own implementation is not taken on trust."""
    VECTORS = [
        (SEED.hex(), PUBLIC.hex(), "",
         "e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e065224901555fb8821590a33bacc61e39701cf9b46bd25bf5f0595bbe24655141438e7a100b"),
        ("4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb",
         "3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c", "72",
         "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00"),
        ("c5aa8df43f9f837bedb7442f31dcb7b166d38535076f094b85ce3a2e0b4458f7",
         "fc51cd8e6218a1a38da47ed00230f0580816ed13ba3303ac5deb911548908025", "af82",
         "6291d657deec24024827e69c3abe01a30ce548a284743a445e3680d7db5ac3ac18ff9b538d16f290ae67f760984dc6594a7c15e9716ed28dc027beceea1ec40a"),
    ]

    def test_gives_the_published_signatures(self):
        for seed, public, message, signature in self.VECTORS:
            seed, public, message, signature = map(bytes.fromhex, (seed, public, message, signature))
            self.assertEqual(ed25519.public_key(seed), public)
            self.assertEqual(ed25519.sign(seed, message), signature)
            self.assertTrue(ed25519.verify(public, message, signature))
            self.assertFalse(ed25519.verify(public, message + b"x", signature))


class KeyFiles(KeyTest):
    def test_secret_key_is_for_its_owner_only_whatever_the_umask(self):
        for umask in (0o000, 0o022, 0o277):
            name = f"key-{umask:o}"
            self.soak("key", "new", "-o", self.folder / name, preexec_fn=lambda mask=umask: os.umask(mask))
            mode = stat.S_IMODE((self.folder / name).stat().st_mode)
            self.assertEqual(mode & 0o177, 0, oct(mode))

    def test_new_writes_both_files_and_show_reads_both(self):
        document = self.soak_json("key-new", "key", "new", "-o", self.folder / "k", "--comment", "Labor 1 \u00e4\u00f6, 2027")
        lines = (self.folder / "k.pub").read_text(encoding="utf-8").splitlines()
        self.assertEqual(lines, ["soak-public-key-1", document["public_key"], "comment Labor 1 \u00e4\u00f6, 2027"])
        seed = bytes.fromhex((self.folder / "k").read_text(encoding="utf-8").splitlines()[1])
        self.assertEqual(ed25519.public_key(seed).hex(), document["public_key"])
        self.assertEqual(hashlib.sha256(bytes.fromhex(document["public_key"])).hexdigest()[:16], document["key_id"])
        for name, kind in (("k", "secret"), ("k.pub", "public")):
            shown = self.soak("key", "show", self.folder / name, "--json")
            self.assertNotIn(seed.hex(), shown.stdout)
            shown = self.soak_json("key-show", "key", "show", self.folder / name)
            self.assertEqual((shown["kind"], shown["key_id"], shown["public_key"], shown["comment"]),
                             (kind, document["key_id"], document["public_key"], document["comment"]))

    def test_two_keys_differ(self):
        self.assertNotEqual(self.key("a").read_text(), self.key("b").read_text())

    def test_new_never_overwrites_either_file(self):
        key = self.key()
        before = key.read_bytes(), self.folder.joinpath("lab.key.pub").read_bytes()
        self.refusal("key", "new", "-o", key)
        self.assertEqual(before, (key.read_bytes(), self.folder.joinpath("lab.key.pub").read_bytes()))
        key.unlink()
        self.assertIn("lab.key.pub", self.refusal("key", "new", "-o", key)["where"])
        self.assertFalse(key.exists(), "a secret key without its public half")
        self.assertEqual(before[1], self.folder.joinpath("lab.key.pub").read_bytes())

    def test_new_refuses_what_it_cannot_write(self):
        self.refusal("key", "new", "-o", self.folder / "no" / "such" / "folder")
        self.refusal("key", "new", "-o", self.folder / "k", "--comment", "two\nlines")
        self.assertFalse((self.folder / "k").exists())

    def test_a_full_disk_leaves_no_half_key(self):
        self.refusal("key", "new", "-o", self.folder / "k", status=1, preexec_fn=limit_file_size(50))
        self.assertFalse((self.folder / "k").exists())
        self.assertFalse((self.folder / "k.pub").exists())

    def test_a_secret_key_that_others_can_read_is_refused(self):
        key = self.key()
        for mode in (0o640, 0o604, 0o620, 0o602):
            key.chmod(mode)
            self.refusal("key", "sign", self.file, "--key", key)
            self.assertEqual(self.file.read_bytes(), self.unsigned)

    def test_what_is_no_key_file_is_refused(self):
        good = f"soak-public-key-1\n{PUBLIC.hex()}\n"
        self.soak("key", "show", self.write("good.pub", good))
        self.soak("key", "show", self.write("crlf.pub", good.replace("\n", "\r\n")))
        bad = ["", "x", good[:40], good.replace("d7", "g7"), good.replace("d7", "d "), good + "more\n", good + "comment x\ny\n",
               good.replace("-1", "-2"), PUBLIC.hex(), good.replace("d75a", "D75A0"), "soak-public-key-1\n+1" + PUBLIC.hex()[2:] + "\n"]
        for text in bad:
            with self.subTest(text=text):
                self.refusal("key", "show", self.write("bad.pub", text))
        self.refusal("key", "show", self.folder / "absent")
        self.refusal("key", "show", self.file)

    def test_the_wrong_half_is_refused_by_name(self):
        key = self.key()
        self.refusal("key", "sign", self.file, "--key", f"{key}.pub")
        self.refusal("key", "verify", self.file, "--key", key)


class Signatures(KeyTest):
    def test_a_signed_file_is_what_the_format_says_byte_for_byte(self):
        document = self.soak_json("key-sign", "key", "sign", self.file, "--key", self.known_key())
        data = self.file.read_bytes()
        self.assertEqual(data, expected_signed(self.unsigned, SEED))
        self.assertEqual(data, (GOLDEN / "signed.soakcal").read_bytes(), "the golden file")
        self.assertEqual(document["sha256"], hashlib.sha256(data).hexdigest())
        self.assertEqual((document["bytes"], document["replaced"], document["unit"]), (len(data), False, "SN-0001"))

    def test_what_a_stranger_needs_to_verify_stands_in_the_last_bytes(self):
        key = self.key()
        data = self.signed(key)
        public = bytes.fromhex((self.folder / "lab.key.pub").read_text().splitlines()[1])
        self.assertEqual(data[-84:-76], bytes.fromhex("4000010048000000"))
        self.assertTrue(ed25519.verify(public, b"soak-signature-1" + data[:-68], data[-68:-4]))

    def test_round_trip(self):
        key = self.key("lab.key", "--comment", "Lab 1")
        self.signed(key)
        document = self.soak_json("key-verify", "key", "verify", self.file, "--key", f"{key}.pub")
        self.assertEqual((document["unit"], document["model"], document["comment"]), ("SN-0001", 7, "Lab 1"))
        self.assertIn("good", self.soak("key", "verify", self.file, "--key", f"{key}.pub").stdout)

    @long_test
    def test_readers_of_version_1_0_read_a_signed_file_as_before(self):
        before = Calibration.load(self.unsigned)
        points = self.soak("eval", self.file, "--temp-c", "-30,12.5,90", "--json").stdout
        data = self.signed(self.key())
        after = Calibration.load(data)
        self.assertEqual(len(list(read_sections(data))), len(list(read_sections(self.unsigned))) + 1)
        self.assertEqual((before.serial, before.sensors, before.curves), (after.serial, after.sensors, after.curves))
        self.assertEqual(self.soak("eval", self.file, "--temp-c", "-30,12.5,90", "--json").stdout, points)

    def test_an_unsigned_file_is_told_from_a_damaged_one(self):
        key = self.key()
        self.refusal("key", "verify", self.file, "--key", f"{key}.pub", status=4)
        self.write("SN.soakcal", self.unsigned[:-1])
        self.refusal("key", "verify", self.file, "--key", f"{key}.pub", status=4)

    def test_a_flipped_bit_anywhere_is_found(self):
        key = self.known_key()
        data = self.signed(key)
        self.assertEqual(self.verify_status(data, "--key", f"{key}.pub"), 0)
        # One bit of every 61st byte; tests/station/signing_test.cpp flips many more.
        for at in range(0, len(data), 61):
            changed = bytearray(data)
            changed[at] ^= 1 << at % 8
            self.assertEqual(self.verify_status(changed, "--key", f"{key}.pub"), 4, at)

    @long_test
    def test_a_flipped_bit_anywhere_is_found_by_somebody_who_mends_the_crc(self):
        key = self.known_key()
        data = self.signed(key)
        places = [*range(8, 24), *range(24, len(data) - 84, 127), *range(len(data) - 84, len(data) - 4, 5)]
        for at in places:
            changed = bytearray(data)
            changed[at] ^= 1 << at % 8
            changed[-4:] = struct.pack("<I", crc32c(bytes(changed[:-4])))
            # 2: a newer version, or a critical section of a type that nobody knows
            self.assertIn(self.verify_status(changed, "--key", f"{key}.pub"), (2, 4), at)
        self.assertEqual(self.verify_status(data, "--key", f"{key}.pub"), 0)

    def test_no_part_of_the_file_can_be_taken_away_or_added(self):
        key = self.known_key()
        data = self.signed(key)
        sections = list(read_sections(data))
        self.assertEqual(sections[-1].kind, SIGNATURE_TYPE)
        for left_out in range(1, len(sections) - 1):
            kept = [s for i, s in enumerate(sections) if i != left_out]
            self.assertNotEqual(self.verify_status(self.file_of(data, kept), "--key", f"{key}.pub"), 0, left_out)
        private = b"".join([struct.pack("<HBBI", 0x8000, 1, 0, 0)])
        added = sealed(data[:20] + struct.pack("<I", len(sections) + 1) + data[24:-84] + private + data[-84:])
        self.assertEqual(self.verify_status(added, "--key", f"{key}.pub"), 4)
        behind = sealed(data[:20] + struct.pack("<I", len(sections) + 1) + data[24:-4] + private + data[-4:])
        self.assertEqual(self.verify_status(behind, "--key", f"{key}.pub"), 4)
        for end in (len(data) - 1, len(data) - 84, len(data) // 2, 100):
            self.assertEqual(self.verify_status(data[:end], "--key", f"{key}.pub"), 4, end)
        self.assertEqual(self.verify_status(sealed(data[:20] + struct.pack("<I", len(sections) - 1) + data[24:-84] + bytes(4)),
                                            "--key", f"{key}.pub"), 4)

    @staticmethod
    def file_of(data, sections):
        body = b"".join(struct.pack("<HBBI", s.kind, s.version, s.critical, len(s.payload)) + s.payload for s in sections)
        return sealed(data[:20] + struct.pack("<I", len(sections)) + body + bytes(4))

    @long_test
    def test_another_key_does_not_pass(self):
        data = self.signed(self.key("ours"))
        self.key("theirs")
        self.refusal("key", "verify", self.file, "--key", self.folder / "theirs.pub", status=4)
        # their signature under our key's number
        ours = hashlib.sha256(bytes.fromhex((self.folder / "ours.pub").read_text().splitlines()[1])).digest()[:8]
        self.soak("key", "sign", self.file, "--key", self.folder / "theirs")
        forged = bytearray(self.file.read_bytes())
        forged[-76:-68] = ours
        forged[-4:] = struct.pack("<I", crc32c(bytes(forged[:-4])))
        self.assertEqual(self.verify_status(forged, "--key", self.folder / "ours.pub"), 4)
        self.assertEqual(self.verify_status(data, "--key", self.folder / "ours.pub"), 0)

    @long_test
    def test_signing_again_replaces_the_signature(self):
        first, second = self.key("first"), self.key("second")
        self.signed(first)
        document = self.soak_json("key-sign", "key", "sign", self.file, "--key", second)
        self.assertTrue(document["replaced"])
        data = self.file.read_bytes()
        self.assertEqual([s.kind for s in read_sections(data)].count(SIGNATURE_TYPE), 1)
        self.assertEqual(self.verify_status(data, "--key", f"{second}.pub"), 0)
        self.assertEqual(self.verify_status(data, "--key", f"{first}.pub"), 4)
        self.assertEqual(self.signed(first), self.signed(first), "deterministic")

    @long_test
    def test_sections_of_a_later_version_are_kept_and_signed(self):
        later = struct.pack("<HBBI4s", 0x0055, 1, 0, 4, b"next")
        sections = struct.unpack_from("<I", self.unsigned, 20)[0]
        self.write("SN.soakcal", sealed(self.unsigned[:10] + struct.pack("<HIII", 9, 0, 24, sections + 1) + self.unsigned[24:-4] + later + bytes(4)))
        key = self.key()
        data = self.signed(key)
        self.assertEqual(struct.unpack_from("<H", data, 10)[0], 9)
        self.assertIn(later, data)
        self.assertEqual(self.verify_status(data, "--key", f"{key}.pub"), 0)
        self.assertEqual(self.verify_status(sealed(data.replace(b"next", b"text")), "--key", f"{key}.pub"), 4)

    def test_trusted_folder(self):
        key = self.key("lab.key", "--comment", "ours")
        self.signed(key)
        trusted = self.folder / "trusted"
        self.refusal("key", "verify", self.file, "--trusted", trusted)
        trusted.mkdir()
        self.refusal("key", "verify", self.file, "--trusted", trusted)
        self.key("other")
        shutil.copy(self.folder / "other.pub", trusted / "a.pub")
        self.refusal("key", "verify", self.file, "--trusted", trusted, status=4)
        shutil.copy(f"{key}.pub", trusted / "b.pub")
        document = self.soak_json("key-verify", "key", "verify", self.file, "--trusted", trusted)
        self.assertEqual((document["comment"], document["key_file"]), ("ours", str(trusted / "b.pub")))
        self.write("trusted/c.pub", "damaged")
        self.assertIn("c.pub", self.refusal("key", "verify", self.file, "--trusted", trusted)["where"])

    def test_a_failed_signing_leaves_the_file_as_it_was(self):
        key = self.known_key()
        self.refusal("key", "sign", self.file, "--key", key, status=1, preexec_fn=limit_file_size(2000))
        self.assertEqual(self.file.read_bytes(), self.unsigned)
        self.assertEqual(list(self.folder.glob("*.tmp*")), [])
        self.write("damaged.soakcal", self.unsigned[:-8])
        self.refusal("key", "sign", self.folder / "damaged.soakcal", "--key", key, status=4)
        self.assertEqual((self.folder / "damaged.soakcal").read_bytes(), self.unsigned[:-8])

    @long_test
    def test_a_file_without_room_is_refused(self):
        free = struct.pack("<HBBI", 0x8000, 1, 0, 0)
        count = struct.unpack_from("<I", self.unsigned, 20)[0]
        full = sealed(self.unsigned[:20] + struct.pack("<I", 256) + self.unsigned[24:-4] + free * (256 - count) + bytes(4))
        self.write("SN.soakcal", full)
        self.refusal("key", "sign", self.file, "--key", self.known_key())

    def test_verify_needs_one_of_its_options(self):
        self.refusal("key", "verify", self.file)
        self.refusal("key", "verify", self.file, "--key", "a", "--trusted", "b")


class Reader(unittest.TestCase):
    def test_sealed_keeps_a_good_file(self):
        data = (GOLDEN / "fis.soakcal").read_bytes()
        self.assertEqual(sealed(data), data)
        with self.assertRaises(BlobError):
            Calibration.load(data[:-1])


if __name__ == "__main__":
    unittest.main()
