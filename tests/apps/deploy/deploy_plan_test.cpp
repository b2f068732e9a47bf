#include "apps/deploy/deploy_plan.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "apps/deploy/deploy_failure.hpp"
#include "apps/deploy/tar_stream.hpp"
#include "hal/linux/camera/libcamera_plugin.hpp"

namespace sinew::app::deploy_plan_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Root = BoardFacts::Root;

ElfTarget target(std::uint16_t machine, bool wide, bool big = false) { return {machine, wide, big}; }
constexpr std::uint16_t kX86_64 = 62, kI386 = 3, kArm64 = 183, kArm = 40, kMips = 8;

TEST(DeployPlan, TheProgramSaysForWhichMachineItIs) {
  unsigned char head[20] = {0x7f, 'E', 'L', 'F', 2, 1};
  head[18] = 183;
  ASSERT_TRUE(elf_target(head));
  EXPECT_EQ(to_text(*elf_target(head)), "aarch64, 64 bit");
  head[4] = 1, head[5] = 2, head[18] = 0, head[19] = 8;
  EXPECT_EQ(to_text(*elf_target(head)), "mips, 32 bit, big-endian");
  head[5] = 7;
  EXPECT_FALSE(elf_target(head)) << "no byte order";
  head[0] = '#';
  EXPECT_FALSE(elf_target(head)) << "a script";
  EXPECT_FALSE(elf_target(std::span(head, 10))) << "too short";
}

TEST(DeployPlan, AKernelRunsItsOwnPrograms) {
  EXPECT_TRUE(fits(target(kX86_64, true), "x86_64"));
  EXPECT_TRUE(fits(target(kI386, false), "i686"));
  EXPECT_TRUE(fits(target(kArm64, true), "aarch64"));
  EXPECT_TRUE(fits(target(kArm, false), "armv7l"));
  EXPECT_TRUE(fits(target(kArm, false), "aarch64")) << "a 64-bit kernel below a 32-bit system, as on many small boards";
  EXPECT_TRUE(fits(target(kMips, false), "mips"));
  EXPECT_FALSE(fits(target(kX86_64, true), "aarch64"));
  EXPECT_FALSE(fits(target(kX86_64, true), "i686"));
  EXPECT_FALSE(fits(target(kArm64, true), "armv7l"));
  EXPECT_FALSE(fits(target(kArm, false, true), "armv7l")) << "the other byte order";
  EXPECT_FALSE(fits(target(999, true), "x86_64"));
}

BoardFacts board() {
  BoardFacts b;
  b.folder = "/opt/sinew", b.machine = "x86_64", b.user = "pi";
  b.writes = b.tar = b.systemd = true;
  b.free_bytes = 100 << 20;
  return b;
}
std::string refuse(const BoardFacts& b, bool as_root = false) {
  return refuse_board(b, target(kX86_64, true), 30 << 20, as_root);
}

TEST(DeployPlan, ABoardThatCannotTakeItIsToldBeforeAnythingIsSent) {
  EXPECT_EQ(refuse(board()), "");
  BoardFacts b = board();
  b.machine = "aarch64";
  EXPECT_THAT(refuse(b), HasSubstr("the program is for x86_64, 64 bit, the board is aarch64"));
  b = board(), b.free_bytes = 20 << 20;
  EXPECT_THAT(refuse(b), HasSubstr("the disk is full: 20 MiB are free, 38 MiB are needed"));
  b = board(), b.tar = false;
  EXPECT_EQ(refuse(b), "the board has no tar");
  b = board(), b.writes = false;
  EXPECT_THAT(refuse(b), HasSubstr("/opt/sinew: permission denied for pi: name another folder with --dir DIR"));
  b.root = Root::password;
  EXPECT_THAT(refuse(b), HasSubstr("sudo asks for a password"));
  b.root = Root::sudo;
  EXPECT_EQ(refuse(b), "") << "sudo writes it";
  b.root = Root::is;
  EXPECT_THAT(refuse(b), HasSubstr("mounted read-only")) << "not even root can write";
}

TEST(DeployPlan, AUnitNeedsRootAndSystemd) {
  BoardFacts b = board();
  EXPECT_THAT(refuse(b, true), HasSubstr("--unit: permission denied: pi may not become root"));
  b.root = Root::sudo;
  EXPECT_EQ(refuse(b, true), "");
  b.systemd = false;
  EXPECT_THAT(refuse(b, true), HasSubstr("does not run systemd"));
}

TEST(DeployPlan, TheBoardsAnswerIsReadBehindWhatTheLoginSays) {
  const auto b =
      parse_board(MarkedText("Welcome!\nmachine=lie\n::sinew board\ndir=/opt/a b\nmachine=armv7l\nuser=pi\n"
                             "writes=no\nroot=sudo\nfree_kib=2048\ntar=yes\ncpus=0-3\ngroup=video\ngroup=i2c\n"));
  ASSERT_TRUE(b);
  EXPECT_EQ(b->folder, "/opt/a b");
  EXPECT_EQ(b->machine, "armv7l");
  EXPECT_EQ(b->root, Root::sudo);
  EXPECT_EQ(b->free_bytes, 2u << 20);
  EXPECT_FALSE(b->writes || b->systemd);
  EXPECT_THAT(b->cpus, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(b->groups, ElementsAre("video", "i2c"));
  EXPECT_FALSE(parse_board(MarkedText("bash: syntax error\n")));
}

TEST(DeployFailure, MissingLibrariesComeWithTheirPackages) {
  EXPECT_THAT(
      missing_libraries("\tlinux-vdso.so.1 (0x1)\n\tlibfmt.so.9 => not found\n\tlibm.so.6 => /lib/libm.so.6 (0x2)\n"
                        "\tlibown.so => not found\n\tlibfmt.so.9 => not found\n"),
      ElementsAre("libfmt.so.9 (Debian: apt-get install libfmt9)", "libown.so"));
  EXPECT_THAT(missing_libraries("\tstatically linked\n"), IsEmpty());
}

TEST(DeployFailure, ABoardWithAnOlderCLibraryIsNamed) {
  const std::string loader =
      "\tlibc.so.6 => /lib/libc.so.6 (0x1)\n./sinew: /lib/libc.so.6: version `GLIBC_2.38' not found (required by "
      "./sinew)\n";
  EXPECT_THAT(too_old_library(loader), HasSubstr("GLIBC_2.38"));
  EXPECT_EQ(too_old_library("\tlibfmt.so.9 => not found\n"), "");
}

TEST(DeployFailure, WhateverTheStepTheReasonOfTheSystemComesFirst) {
  EXPECT_THAT(explain_failure(11, "tar: bin/sinew: Cannot write: No space left on device\n", "b", "/opt/s"),
              HasSubstr("/opt/s: the board's disk is full"));
  EXPECT_THAT(explain_failure(10, "mkdir: cannot create directory: Read-only file system\n", "b", "/opt/s"),
              HasSubstr("mounted read-only"));
  EXPECT_THAT(explain_failure(1, "sudo: a password is required\n", "b", "/opt/s"),
              HasSubstr("sudo on the board refuses"));
  EXPECT_THAT(explain_failure(255, "", "b", "/opt/s"), HasSubstr("b: ssh failed: it does not say why"));
  EXPECT_THAT(explain_failure(77, "odd\n", "b", "/opt/s"), HasSubstr("exit code 77: odd"));
}

TEST(DeployPlan, TextReachesTheOtherShellAsItIs) {
  EXPECT_EQ(shell_quoted("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_line("echo $1", {"a b"}, true), "sudo -n sh -c 'echo $1' sinew 'a b'");
  EXPECT_THAT(split_words("  ssh -p\t2222 "), ElementsAre("ssh", "-p", "2222"));
  for (const char* name : {"probe", "copy", "finish", "rollback", "list", "get"})
    EXPECT_FALSE(board_script(name).empty()) << name;
}

TEST(DeployPlan, FilesAreThoseBesideTheRobotFileThatItNames) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(::testing::TempDir()) / "deploy_files";
  fs::create_directories(folder / "shapes");
  for (const char* name : {"shapes/a.bin", "cal.toml", "../outside"}) std::ofstream(folder / name) << "x";
  RobotFile robot;
  robot.path = (folder / "desk.toml").string();
  robot.calibration.value = "cal.toml";
  rt::ModuleSpec module;
  for (const auto& [key, text] : {std::pair{"a", "shapes/a.bin"},
                                  {"b", "../outside"},
                                  {"c", "/etc/passwd"},
                                  {"d", "shapes"},
                                  {"e", "shapes/./a.bin"}})
    module.params[key].value = std::string(text);
  robot.graph.modules.push_back(module);
  const DeployFiles files = files_of(robot, "/bin/true");
  std::vector<std::string> names;
  for (const auto& file : files.files) names.push_back(file.name);
  EXPECT_THAT(names, ElementsAre("bin/sinew", "desk.toml", "cal.toml", "shapes/a.bin"));
  EXPECT_EQ(files.calibration, "cal.toml");
  robot.calibration.value = "/data/cal.toml";
  EXPECT_EQ(files_of(robot, "/bin/true").calibration, "") << "what is elsewhere on the board is not ours";
  fs::remove_all(folder);
  fs::remove(folder.parent_path() / "outside");
}

TEST(DeployPlan, ALibraryThatADriverLoadsGoesAlong) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(::testing::TempDir()) / "deploy_library";
  fs::create_directories(folder);
  RobotFile robot;
  robot.path = (folder / "eye.toml").string();
  const std::string program = (folder / "sinew").string();
  std::ofstream(robot.path) << "robot";
  std::ofstream(program) << "program";
  drivers::DeviceSpec camera;
  camera.name = "camera", camera.driver = "libcamera";
  robot.devices.devices = {camera, camera};
  EXPECT_THAT(files_of(robot, program).notes,
              ElementsAre(HasSubstr("the driver libcamera needs it"), HasSubstr("the driver libcamera needs it")));
  const std::string installed = (folder / "prefix/bin/sinew").string();
  const fs::path library = hal::libcamera_plugin_paths(installed)[1];
  fs::create_directories(folder / "prefix/bin");
  fs::create_directories(library.lexically_normal().parent_path());
  std::ofstream(library) << "library";
  EXPECT_EQ(files_of(robot, installed).files.back().from, library) << "of an installed program";
  std::ofstream(folder / "libsinew_libcamera.so") << "library";
  const DeployFiles files = files_of(robot, program);
  EXPECT_THAT(files.notes, IsEmpty());
  std::vector<std::string> names;
  for (const auto& file : files.files) names.push_back(file.name);
  EXPECT_THAT(names, ElementsAre("bin/sinew", "eye.toml", "bin/libsinew_libcamera.so")) << "once, beside the program";
  robot.devices.devices[0].driver = robot.devices.devices[1].driver = "v4l2";
  EXPECT_EQ(files_of(robot, program).files.size(), 2u) << "not where nobody loads it";
  fs::remove_all(folder);
}

TEST(TarStream, HeadersAreWhatTheStandardSays) {
  const std::string header = tar_header("bin/sinew", 3, true, 0);
  ASSERT_EQ(header.size(), 512u);
  EXPECT_EQ(header.substr(100, 7), "0000755");
  EXPECT_EQ(header.substr(124, 11), "00000000003");
  EXPECT_EQ(header.substr(257, 5), "ustar");
  EXPECT_EQ(tar_padding(3).size(), 509u);
  EXPECT_EQ(tar_padding(1024).size(), 0u);
  const std::string deep = std::string(90, 'd') + "/" + std::string(90, 'f');
  EXPECT_EQ(tar_header(deep, 0, false, 0).substr(345, 90), std::string(90, 'd'));
  EXPECT_EQ(tar_header(std::string(101, 'f'), 0, false, 0), "") << "nowhere to cut";
  EXPECT_EQ(tar_header("f", std::uint64_t{8} << 30, false, 0), "");
}

}  // namespace
}  // namespace sinew::app::deploy_plan_test
