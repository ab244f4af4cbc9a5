# SPDX-License-Identifier: Apache-2.0
"""The Debian packages as a user unpacks them, without installing. The whole way on a bare machine: ./run prove package."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
RELEASE = pathlib.Path(os.environ["SOAK_RELEASE_BUILD"])
PAGES = RELEASE / "command_pages"


def run(*words, **options):
    return subprocess.run([*map(str, words)], check=True, capture_output=True, text=True, **options).stdout


@unittest.skipUnless(shutil.which("dpkg-shlibdeps") and shutil.which("file"), "dpkg-dev and file are not installed: skipped")
class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        run(sys.executable, "-B", ROOT / "tools" / "command_pages.py", RELEASE / "bin", PAGES)
        run("cpack", "--config", RELEASE / "CPackConfig.cmake", "-B", cls.folder, "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip", cwd=cls.folder)
        for package in cls.folder.glob("*.deb"):
            run("dpkg-deb", "-R", package, cls.folder / package.name.split("_")[0])
        cls.soak = cls.folder / "soak"

    def program(self, name, *words):
        """As installed: without this checkout's environment."""
        return run(self.soak / "usr" / "bin" / name, *words, cwd=self.folder, env={"PATH": "/usr/bin:/bin", "HOME": str(self.folder)})

    def test_they_hold_what_a_station_needs_and_nothing_elsewhere(self):
        for path in ("usr/bin/soak", "usr/bin/soakd", "usr/bin/soaksim", "usr/bin/soak-demo", "usr/lib/systemd/system/soakd.service",
                     "usr/lib/udev/rules.d/60-soak.rules", "usr/share/soak/procedures/chambers/watlow-f4t.toml",
                     "usr/share/soak/procedures/units/mti-300.toml", "usr/share/man/man1/soak-campaign-start.1",
                     "usr/share/bash-completion/completions/soak", "usr/share/doc/soak/docs/operations.md", "etc/soak/station.toml"):
            self.assertTrue((self.soak / path).is_file(), path)
        self.assertEqual({path.name for path in self.soak.iterdir()}, {"DEBIAN", "etc", "usr"})
        library = self.folder / "libsoak-dev"
        for path in ("usr/lib/libsoak_anfis.a", "usr/lib/cmake/soak/soakConfig.cmake", "usr/include/soak/calib/runtime/soak_runtime.h"):
            self.assertTrue((library / path).is_file(), path)
        self.assertEqual({path.name for path in library.iterdir()}, {"DEBIAN", "usr"})

    def test_the_programs_find_what_came_with_them(self):
        self.assertIn("mti-300", self.program("soak", "type", "list"))
        procedure = self.soak / "usr/share/soak/procedures/six-position-both-ways.toml"
        self.assertIn("h", self.program("soak", "procedure", "check", procedure, "--type", "mti-300"))
        self.assertIn(f'map = "{self.soak}/usr/share/soak/procedures/chambers/', self.program("soakd", "--write-config"))
        self.assertIn("simulated laboratory", self.program("soak-demo", "--help"))
        self.program("soaksim-truth", "--seed", "1", "--units", "1")

    def test_the_configuration_and_the_service_name_installed_files(self):
        text = (self.soak / "etc/soak/station.toml").read_text(encoding="utf-8")
        maps = [line.split('"')[1] for line in text.splitlines() if line.startswith("map = ")]
        self.assertTrue(maps)
        for path in maps:
            self.assertTrue((self.soak / path.lstrip("/")).is_file(), path)
        for service, programs in (("soakd", ("soakd", "soak")), ("soakd-alarm", ("soak",))):
            text = (self.soak / "usr/lib/systemd/system" / (service + ".service")).read_text(encoding="utf-8")
            for program in programs:
                self.assertIn(f"/usr/bin/{program} ", text)
        # soakd takes the template for no configuration as long as nothing but its comments is changed.
        template = (self.soak / "etc/soak/station.toml").read_text(encoding="utf-8")
        self.assertEqual(template.replace('"/usr/', f'"{self.soak}/usr/'), self.program("soakd", "--write-config"))
        self.assertIn("/etc/soak/station.toml\n", (self.soak / "DEBIAN/conffiles").read_text(encoding="utf-8"))

    def test_they_depend_on_the_libraries_that_the_programs_load(self):
        control = (self.soak / "DEBIAN/control").read_text(encoding="utf-8")
        loaded = run("objdump", "-p", self.soak / "usr/bin/soakd")
        for library, package in (("libsqlite3.so", "libsqlite3-0"), ("libmodbus.so", "libmodbus5"), ("libsodium.so", "libsodium23")):
            self.assertIn(library, loaded)
            self.assertIn(package, control)

    def test_scripts_of_the_package_are_plain_shell(self):
        for name in ("preinst", "postinst", "prerm", "postrm"):
            run("sh", "-n", self.soak / "DEBIAN" / name)

    def test_every_command_has_a_man_page_with_its_options(self):
        pages = {path.stem: path.read_text(encoding="utf-8") for path in (self.soak / "usr/share/man/man1").glob("*.1")}
        self.assertIn("\\-\\-chamber\\-time", pages["soak-fit"])
        self.assertIn(".BR soak-campaign-start (1)", pages["soak-campaign"])
        for name in ("soak", "soakd", "soaksim", "soak-gap-accept", "soak-chamber-make-safe"):
            self.assertIn(name, pages)
        if shutil.which("groff"):
            for path in (self.soak / "usr/share/man/man1").glob("*.1"):
                done = subprocess.run(["groff", "-man", "-Tutf8", "-wall", path], capture_output=True, text=True, check=True)
                self.assertEqual(done.stderr, "", path.name)

    def test_bash_completes_commands_and_options(self):
        script = self.soak / "usr/share/bash-completion/completions/soak"
        for words, wanted in ((["soak", "camp"], ["campaign"]), (["soak", "campaign", "res"], ["resume"]), (["soak", "fit", "--al"], ["--all"]),
                              (["soak", "fit", "--unit", "A", "--jo"], ["--jobs"])):
            line = f"source {script}; COMP_WORDS=({' '.join(words)}); COMP_CWORD={len(words) - 1}; _soak; echo ${{COMPREPLY[@]}}"
            self.assertEqual(run("bash", "-c", line).split(), wanted)


if __name__ == "__main__":
    unittest.main()
