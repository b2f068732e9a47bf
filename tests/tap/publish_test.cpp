// Bytes to a robot over its socket, from clients that lie about them.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <thread>

#include "hal/linux/shared_memory.hpp"
#include "tap_rig.hpp"

namespace sinew::tap::publish_test {
namespace {

OwnRunDir g_run_dir;

/// Memory with the seals that the test wants, mapped writable.
class OwnMemory final : public hal::SharedMemory {
 public:
  OwnMemory(std::size_t bytes, int seals)
      : fd_(::memfd_create("client", MFD_CLOEXEC | MFD_ALLOW_SEALING)), size_(bytes) {
    EXPECT_EQ(::ftruncate(fd_, static_cast<off_t>(bytes)), 0);
    if (bytes > 0) data_ = static_cast<std::byte*>(::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, 0));
    EXPECT_EQ(::fcntl(fd_, F_ADD_SEALS, seals), 0);
  }
  ~OwnMemory() override {
    if (data_) ::munmap(data_, size_);
    ::close(fd_);
  }
  OwnMemory(const OwnMemory&) = delete;
  OwnMemory& operator=(const OwnMemory&) = delete;
  std::byte* data() override { return data_; }
  std::size_t size() const override { return size_; }
  std::intptr_t handle() const override { return fd_; }
  bool copy(std::size_t, std::span<std::byte>) const noexcept override { return false; }

 private:
  int fd_;
  std::byte* data_ = nullptr;
  std::size_t size_;
};

constexpr std::size_t kBytes = sizeof(msg::Image) + Eye::kWidth * Eye::kHeight;

struct Publish : testing::Test {
  Publish() : robot({.graph = {.camera = true}}) {
    robot.start();
    client = robot.client();
  }
  Json hand_over(const hal::SharedMemory& memory) {
    const auto reply = client->request_with_memory("publish.memory", "{}", memory);
    return reply ? Json::parse(*reply, nullptr, false) : Json();
  }
  Json publish(const Json& bytes, const Json& offset = 0, const char* topic = "outside.image") {
    return ask(*client, "publish.bytes", {{"topic", topic}, {"offset", offset}, {"bytes", bytes}});
  }
  static void draw(hal::SharedMemory& memory, std::uint8_t value) {
    auto* image = new (memory.data()) msg::Image;
    image->set_bulk_capacity(Eye::kWidth * Eye::kHeight);
    EXPECT_TRUE(image->format_as(msg::PixelFormat::mono8, Eye::kWidth, Eye::kHeight));
    std::fill_n(image->pixels(), Eye::kWidth * Eye::kHeight, value);
  }
  Robot robot;
  std::unique_ptr<Client> client;
};

std::string why(const Json& reply) { return reply.contains("error") ? reply["error"]["why"].get<std::string>() : "ok"; }

TEST_F(Publish, NeedsMemoryFirstAndTakesItOnce) {
  EXPECT_EQ(why(publish(kBytes)), "publish.memory comes first: this connection has handed over none");
  EXPECT_EQ(why(ask(*client, "publish.memory")),
            "no memory came with this request, or it is not the first of its kind");
  client = robot.client();
  OwnMemory memory(kBytes, F_SEAL_SHRINK);
  EXPECT_EQ(hand_over(memory)["bytes"], kBytes);
  EXPECT_EQ(why(hand_over(memory)), "no memory came with this request, or it is not the first of its kind");
}

TEST_F(Publish, RefusesMemoryThatItsOwnerCouldShrink) {
  OwnMemory memory(kBytes, 0);
  EXPECT_EQ(why(hand_over(memory)), "shared memory from the peer is not sealed against shrinking");
  EXPECT_NE(why(publish(kBytes)), "ok");
}

TEST_F(Publish, RefusesSizesThatDoNotFit) {
  OwnMemory memory(kBytes, F_SEAL_SHRINK | F_SEAL_GROW);
  draw(memory, 1);
  ASSERT_EQ(why(hand_over(memory)), "ok");
  const std::string integer = "an integer from 0 to 4294967295";
  for (const Json& no : {Json(-1), Json(1.5), Json("1"), Json(), Json(4294967296), Json(18446744073709551615ULL)}) {
    EXPECT_EQ(why(publish(no)), "\"bytes\": " + integer) << no;
    EXPECT_EQ(why(publish(kBytes, no)), "\"offset\": " + integer) << no;
  }
  EXPECT_EQ(why(publish(kBytes, 1)), std::to_string(kBytes) + " bytes: the memory is shorter than the message");
  EXPECT_EQ(why(publish(kBytes, 4294967295)),
            std::to_string(kBytes) + " bytes: the memory is shorter than the message");
  const std::string has =
      " bytes: Image has " + std::to_string(sizeof(msg::Image)) + ", and behind it at most 32000 of pixels";
  EXPECT_EQ(why(publish(0)), "0" + has);
  EXPECT_EQ(why(publish(4294967295)), "4294967295" + has);
  EXPECT_EQ(why(publish(15, 0, "operator.range")), "15 bytes: RangeSample has 16");
  EXPECT_EQ(why(publish(16, 0, "counter.range")),
            "counter.range is written by module counter; only topics with writer = \"external\" take messages");
  EXPECT_EQ(why(publish(16, 0, "counter.rnage")), "no topic counter.rnage; did you mean counter.range?");
  EXPECT_EQ(why(publish(kBytes)), "ok");
  EXPECT_EQ(why(ask(*client, "publish", {{"topic", "outside.image"}, {"message", Json::object()}})),
            "outside.image holds Image: its messages come in with publish.bytes only");
}

TEST_F(Publish, TakesWholeImagesOrNoneOfMemoryThatChangesMeanwhile) {
  OwnMemory memory(kBytes, F_SEAL_SHRINK | F_SEAL_GROW);
  draw(memory, 1);
  ASSERT_EQ(why(hand_over(memory)), "ok");
  std::atomic<bool> end{false};
  std::thread changer([&] {
    volatile std::uint32_t* stride = &reinterpret_cast<msg::Image*>(memory.data())->stride;
    while (!end.load(std::memory_order_relaxed)) {
      *stride = 0xFFFFFFFF;
      *stride = Eye::kWidth;
    }
  });
  const auto reader = client->reader();
  ASSERT_TRUE(reader);
  const auto topic = *(*reader)->find("outside.image");
  std::vector<std::byte> copy((*reader)->bytes(topic));
  int taken = 0, refused = 0;
  for (int i = 0; i < 150; ++i) {
    const std::string said = why(publish(kBytes));
    if (said != "ok") {
      EXPECT_EQ(said, "an image whose rows do not fit its bytes");
      ++refused;
      continue;
    }
    ++taken;
    const auto message = (*reader)->newest(topic);
    ASSERT_TRUE(message);
    ASSERT_TRUE((*reader)->copy(*message, copy)) << "only this test publishes there";
    EXPECT_EQ(reinterpret_cast<const msg::Image*>(copy.data() + sizeof(rt::SlotHeader))->stride, Eye::kWidth);
  }
  end.store(true);
  changer.join();
  EXPECT_EQ(taken + refused, 150);
}

TEST_F(Publish, AHoleInTheMemoryIsZeros) {
  OwnMemory memory(kBytes, F_SEAL_SHRINK | F_SEAL_GROW);
  draw(memory, 1);
  ASSERT_EQ(why(hand_over(memory)), "ok");
  ASSERT_EQ(::fallocate(static_cast<int>(memory.handle()), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0,
                        static_cast<off_t>(kBytes)),
            0);
  EXPECT_EQ(why(publish(kBytes)), "an image whose rows do not fit its bytes");
}

TEST_F(Publish, WithoutWaitingIsAnsweredAtOnceAndFillsUp) {
  OwnMemory memory(kBytes, F_SEAL_SHRINK | F_SEAL_GROW);
  draw(memory, 1);
  ASSERT_EQ(why(hand_over(memory)), "ok");
  ASSERT_TRUE(ask(*client, "thread.period", {{"thread", "slow"}, {"period_us", 10'000'000}})["ok"]);
  std::vector<std::string> said;
  for (int i = 0; i < 3; ++i) {
    const Json reply =
        ask(*client, "publish.bytes", {{"topic", "outside.image"}, {"offset", 0}, {"bytes", kBytes}, {"wait", false}});
    said.push_back(why(reply));
    EXPECT_EQ(reply.contains("step"), reply["ok"] == true);
  }
  EXPECT_EQ(said.back(), "2 messages of outside.image wait already");
}

TEST_F(Publish, SeveralMessagesOfOneRequestAreEachAcceptedOrRefused) {
  OwnMemory memory(kBytes + 64, F_SEAL_SHRINK | F_SEAL_GROW);
  draw(memory, 1);
  ASSERT_EQ(why(hand_over(memory)), "ok");
  const msg::RangeSample range{{0}, 1.5};
  const std::size_t at = (kBytes + 15) / 16 * 16;
  std::memcpy(memory.data() + at, &range, sizeof range);
  const auto one = [](const char* topic, const Json& offset, std::size_t bytes) {
    return Json{{"topic", topic}, {"offset", offset}, {"bytes", bytes}};
  };
  const Json reply = ask(*client, "publish.bytes",
                         {{"messages",
                           {one("outside.image", 0, kBytes), one("operator.range", at, 15), Json(7),
                            one("operator.range", at, sizeof range), one("operator.range", -1, sizeof range)}}});
  ASSERT_EQ(why(reply), "ok");
  EXPECT_EQ(reply["accepted"], 2);
  ASSERT_EQ(reply["refused"].size(), 3U) << reply;
  EXPECT_EQ(reply["refused"][0]["at"], 1);
  EXPECT_EQ(why(reply["refused"][0]), "15 bytes: RangeSample has 16");
  EXPECT_EQ(why(reply["refused"][1]), "\"topic\": a topic's name");
  EXPECT_EQ(why(reply["refused"][2]), "\"offset\": an integer from 0 to 4294967295");
  for (const Json& no : {Json(), Json(1), Json::array(), Json(std::vector<int>(17))})
    EXPECT_EQ(why(ask(*client, "publish.bytes", {{"messages", no}})), "\"messages\": an array of 1 to 16 objects");
}

}  // namespace
}  // namespace sinew::tap::publish_test
