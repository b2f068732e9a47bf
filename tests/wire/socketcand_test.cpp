#include "wire/socketcand.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "wire/random_can_frame.hpp"

namespace sinew::wire::socketcand_test {
namespace {

SocketcandMessage parsed(std::string_view element) {
  SocketcandMessage out;
  EXPECT_TRUE(socketcand_parse(element, out)) << element;
  return out;
}

bool refused(std::string_view element) {
  SocketcandMessage out;
  return !socketcand_parse(element, out);
}

template <class Encode>
std::string written(Encode encode, const msg::CanFrame& frame) {
  std::string out(kSocketcandMax, ' ');
  out.resize(encode(frame, out));
  return out;
}

std::vector<std::string> elements(SocketcandSplitter& splitter, std::string_view text) {
  std::vector<std::string> found;
  for (const char c : text)
    if (splitter.push(c)) found.emplace_back(splitter.element());
  return found;
}

TEST(Socketcand, ElementsAreFoundWhereverThePiecesEnd) {
  const std::string text = "< hi >< ok >\r\n< frame 123 23.424242 11 22 >";
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    SocketcandSplitter splitter;
    auto found = elements(splitter, text.substr(0, cut));
    for (auto& e : elements(splitter, text.substr(cut))) found.push_back(e);
    ASSERT_EQ(found, (std::vector<std::string>{" hi ", " ok ", " frame 123 23.424242 11 22 "})) << cut;
    EXPECT_EQ(splitter.dropped(), 0u);
  }
}

TEST(Socketcand, ElementsThatDoNotEndAreDroppedAndCounted) {
  SocketcandSplitter splitter;
  EXPECT_EQ(elements(splitter, "< frame 1< ok >"), (std::vector<std::string>{" ok "}));
  EXPECT_EQ(splitter.dropped(), 1u);
  EXPECT_TRUE(elements(splitter, "<" + std::string(kSocketcandMax + 1, 'x') + ">").empty());
  EXPECT_EQ(splitter.dropped(), 2u);
  EXPECT_EQ(elements(splitter, "< hi >").size(), 1u) << "and the stream goes on";
}

TEST(Socketcand, ExamplesOfTheProtocolPageAreRead) {
  SocketcandMessage m = parsed(" send 123 0 ");
  EXPECT_EQ(m.kind, SocketcandKind::send);
  EXPECT_TRUE(same_frame(m.frame, frame_of(0x123, {})));
  m = parsed(" send 1AAAAAAA 2 1 F1 ");
  EXPECT_TRUE(same_frame(m.frame, frame_of(0x1AAAAAAA, {1, 0xF1}, msg::kCanExtended)));
  m = parsed(" sendrtr 1AAAAAAA 2 ");
  EXPECT_TRUE(m.frame.remote() && m.frame.extended());
  EXPECT_EQ(m.frame.size, 2u);
  m = parsed(" frame 123 23.424242 11 22 33 44 ");
  EXPECT_EQ(m.kind, SocketcandKind::frame);
  EXPECT_TRUE(same_frame(m.frame, frame_of(0x123, {0x11, 0x22, 0x33, 0x44})));
  EXPECT_EQ(m.frame.stamp.ns, 23424242000);
  m = parsed(" rtr 123 23.424242 4 ");
  EXPECT_TRUE(m.frame.remote());
  EXPECT_EQ(m.frame.size, 4u);
  EXPECT_EQ(parsed(" open can0 ").text, "can0");
  EXPECT_EQ(parsed(" hi ").kind, SocketcandKind::hi);
  EXPECT_EQ(parsed(" rawmode ").kind, SocketcandKind::raw_mode);
  EXPECT_EQ(parsed(" stat 1 2 3 4 ").kind, SocketcandKind::statistics);
}

TEST(Socketcand, DataMayStandTogetherAsTheRealServerWritesIt) {
  EXPECT_TRUE(same_frame(parsed(" frame 08000123 1.000000 11223344 ").frame,
                         frame_of(0x08000123, {0x11, 0x22, 0x33, 0x44}, msg::kCanExtended)));
  const auto fd = parsed(" fdframe 123 05 1.000000 000102030405060708090A0B ").frame;
  EXPECT_TRUE(fd.fd());
  EXPECT_EQ(fd.size, 12u);
  EXPECT_NE(fd.flags & msg::kCanBitRateSwitch, 0u);
}

TEST(Socketcand, IdentifiersWithoutLeadingZerosAreExtendedByTheirValue) {
  EXPECT_TRUE(parsed(" send 804062A 0 ").frame.extended()) << "as python-can writes";
  EXPECT_FALSE(parsed(" send 5 0 ").frame.extended());
  EXPECT_TRUE(parsed(" send 900 0 ").frame.extended());
  EXPECT_TRUE(parsed(" send 00000005 0 ").frame.extended());
}

TEST(Socketcand, ErrorsAreFramesOrWords) {
  const auto frame = parsed(" error 040 12.500000 ");
  EXPECT_EQ(frame.kind, SocketcandKind::frame);
  EXPECT_TRUE(frame.frame.error());
  EXPECT_EQ(frame.frame.id, 0x40u);
  const auto words = parsed(" error could not open bus ");
  EXPECT_EQ(words.kind, SocketcandKind::refused);
  EXPECT_EQ(words.text, "could not open bus");
}

TEST(Socketcand, BrokenElementsAreRefused) {
  for (const char* bad : {"",
                          " ",
                          " what ",
                          " hi there ",
                          " frame ",
                          " frame 123 ",
                          " frame 123 12 11 ",
                          " frame xyz 1.0 11 ",
                          " frame 123 1.0 1122334455667788 99 ",
                          " frame 20000000 1.0 11 ",
                          " frame 123 1.0 111 ",
                          " send 123 2 11 ",
                          " send 123 1 11 22 ",
                          " send 123 9 1 2 3 4 5 6 7 8 9 ",
                          " send 123 -1 ",
                          " sendrtr 123 9 ",
                          " rtr 123 1.0 ",
                          " fdsend 123 0 9 1 2 3 4 5 6 7 8 9 ",
                          " open ",
                          " open a_name_of_many_letters ",
                          " open can0 can1 "})
    EXPECT_TRUE(refused(bad)) << bad;
}

TEST(Socketcand, ElementsAreWrittenAsTheProtocolSays) {
  EXPECT_EQ(written(socketcand_send, frame_of(0x123, {0x11, 2})), "< send 123 2 11 02 >");
  EXPECT_EQ(written(socketcand_send, frame_of(0x123, {}, msg::kCanExtended)), "< send 00000123 0 >");
  EXPECT_EQ(written(socketcand_send, frame_of(0x123, {1}, msg::kCanFd | msg::kCanBitRateSwitch)),
            "< fdsend 123 01 1 01 >");
  msg::CanFrame frame = frame_of(0x123, {0x11, 0x22});
  frame.stamp.ns = 23424242000;
  EXPECT_EQ(written(socketcand_frame, frame), "< frame 123 23.424242 1122 >");
  EXPECT_EQ(written(socketcand_frame, frame_of(0x40, {}, msg::kCanError)), "< error 040 0.000000 >");
  EXPECT_EQ(written(socketcand_send, frame_of(0x40, {}, msg::kCanError)), "") << "nobody can send an error frame";
  std::string out(40, ' ');
  EXPECT_EQ(out.substr(0, socketcand_open("can0", out)), "< open can0 >");
  EXPECT_EQ(socketcand_open("can0 ><", out), 0u);
}

TEST(Socketcand, EveryFrameComesBackAsItWas) {
  std::mt19937 random(3);
  for (int i = 0; i < 3000; ++i) {
    const msg::CanFrame frame = random_can_frame(random, true, true);
    for (const std::string& text : {written(socketcand_send, frame), written(socketcand_frame, frame)}) {
      SocketcandSplitter splitter;
      const auto found = elements(splitter, text);
      ASSERT_EQ(found.size(), 1u) << text;
      ASSERT_TRUE(same_frame(parsed(found[0]).frame, frame)) << text;
    }
  }
}

}  // namespace
}  // namespace sinew::wire::socketcand_test
