#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "local_domain.hpp"
#include "source_dir.hpp"

namespace sinew::net::security_test {
namespace {

using test::becomes;
using test::joined;
using test::local_domain;

class SecurityTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "sinew_dds_security_" + std::to_string(getpid());
    std::filesystem::create_directories(folder_);
    const std::string command = "sh " + sinew::test::source_dir() + "/tests/net/dds/make_security.sh " + folder_;
    if (std::system("openssl version > /dev/null 2>&1") != 0) GTEST_SKIP() << "openssl is missing";
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  ParticipantOptions member(const std::string& name, const std::string& ca = "ca") {
    ParticipantOptions o = local_domain();
    const auto file = [&](const std::string& path) { return folder_ + "/" + path; };
    o.security = {file(ca + ".pem"),
                  file(name + ".pem"),
                  file(name + ".key"),
                  file(ca + ".pem"),
                  file(ca == "ca" ? "governance.p7s" : "strange_governance.p7s"),
                  file(name + ".p7s")};
    return o;
  }

  std::string folder_;
};

EndpointSpec secret() {
  EndpointSpec spec{"secret", "T", {}, {}};
  spec.qos.reliable = true, spec.qos.transient_local = true, spec.qos.depth = 8;
  return spec;
}

TEST_F(SecurityTest, MembersOfOneAuthorityCommunicateAndNobodyElseHearsThem) {
  const auto one = joined(member("one")), two = joined(member("two")), open = joined(),
             other = joined(member("other", "stranger"));
  ASSERT_TRUE(one && two && open && other);
  std::string why;
  const auto writer = one->write(secret(), why);
  ASSERT_TRUE(writer) << why;
  const auto reader = two->read(secret(), why), eavesdropper = open->read(secret(), why),
             stranger = other->read(secret(), why);
  ASSERT_TRUE(reader && eavesdropper && stranger) << why;
  const std::vector<std::uint8_t> cdr{0, 1, 0, 0, 1, 2, 3, 4};
  ASSERT_TRUE((*writer)->write(cdr));
  DdsSample sample;
  ASSERT_TRUE(becomes(*two, [&] { return (*reader)->take(sample); }));
  EXPECT_EQ(sample.cdr, cdr);
  EXPECT_FALSE((*eavesdropper)->take(sample));
  EXPECT_FALSE((*stranger)->take(sample));
  EXPECT_EQ((*writer)->matched(), 1u);
}

TEST_F(SecurityTest, ACertificateOfAnotherAuthorityIsNamed) {
  ParticipantOptions wrong = member("one");
  wrong.security.certificate = folder_ + "/other.pem";
  wrong.security.private_key = folder_ + "/other.key";
  std::string why;
  const auto opened = Participant::open(wrong, why);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, hal::Errc::denied) << why;
  EXPECT_THAT(why, testing::HasSubstr("ertificate"));
}

}  // namespace
}  // namespace sinew::net::security_test
