// Any bytes as the records of a run: steps, requests, heads of images, images. Accepted records come back the same.
#include <cstdint>
#include <cstdlib>

#include "record/run/message_store.hpp"
#include "record/run/run_messages.hpp"

using namespace sinew;
using namespace sinew::record;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  std::vector<LoggedStep> steps, again;
  if (decode(bytes, steps) && !steps.empty()) {
    StepBatch batch;
    for (const LoggedStep& s : steps) batch.add(s);
    if (!decode(batch.bytes(), again) || again != steps) std::abort();
  }
  LoggedRequest request;
  if (decode(bytes, request)) {
    Buffer out;
    encode(out, request);
    LoggedRequest same;
    if (!decode(out.bytes(), same)) std::abort();
  }
  LoggedState state;
  std::uint64_t layout = 0;
  if (decode(bytes, state, layout) && state.bytes.size() > size) std::abort();
  ImageHead head;
  if (decode(bytes, head)) {
    Buffer out;
    encode(out, head);
    ImageHead same;
    if (!decode(out.bytes(), same) || same != head) std::abort();
  }
  MessageStore store(msg::type_info<msg::Image>());
  const bool has_head = store.add_head(1, rt::Time{1}, bytes), has_pixels = store.add_pixels(1, rt::Time{1}, bytes);
  store.add_head(1, rt::Time{1}, bytes);
  const MessageStore::Entry* entry = store.find(1);
  if ((has_head || has_pixels) != (entry != nullptr)) std::abort();
  if (entry && entry->whole && entry->head) {  // all that it uses is there
    const auto& image = *static_cast<const msg::Image*>(entry->message());
    unsigned sum = 0;
    for (std::uint32_t i = 0; i < image.bulk_used(); ++i) sum += image.pixels()[i];
    if (sum == 1) return 0;
  }
  return 0;
}
