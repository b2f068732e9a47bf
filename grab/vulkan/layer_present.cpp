// vkQueuePresentKHR: counts pictures, and copies those that are asked for by a submission to the queue that presents.
#include "grab/vulkan/layer_data.hpp"

namespace sinew::grab {
namespace {

/// The device has copied it: hands it over.
void hand_over(Head& head, DeviceData& d, const SwapchainData& s, Copy& copy) noexcept {
  PixelOrder order{};
  order_of(s.format, order);
  VkMappedMemoryRange range{};
  range.sType = VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE;
  range.memory = copy.memory, range.size = VK_WHOLE_SIZE;
  d.invalidate(d.handle, 1, &range);
  std::memcpy(copy.job.pixels, copy.mapped, static_cast<std::size_t>(copy.job.answer.stride) * copy.job.answer.height);
  finish(head, copy.job, order, false);
  copy.busy = false;
}

/// Counts the picture, and begins the copies that are asked for: appended to `commands`. The views that wait for one
/// that cannot be read are told so.
void begin_copies(Head& head, DeviceData& d, SwapchainData& s, std::uint32_t image, std::uint32_t family,
                  VkCommandBuffer* commands, std::uint32_t most, std::uint32_t& count, VkFence& fence) noexcept {
  Shown shown;
  if (!count_picture(head, Api::vulkan, nullptr, number_of(s.surface), shown)) return;
  const Size size{s.extent.width, s.extent.height};
  if (wants_size(head, shown)) tell_size(head, shown, size);
  if (head.views.load(std::memory_order_relaxed) == 0) return;
  const std::int64_t now = now_ns();
  if (!is_asked(head, shown, now)) return;
  tell_size(head, shown, size);
  const bool can = s.readable && prepared(d, s, family) && image < s.images_count;
  Job job;
  while (count < most && take_job(head, shown, now, size, job)) {
    Copy& copy = s.copies[job.view];
    copy.job = job;
    if (!can || copy.busy || !ready(d, s, copy) || !recorded(d, s, image, copy)) {
      refuse(head, copy.job, AnswerStatus::not_readable);
      continue;
    }
    copy.busy = true;
    commands[count++] = copy.commands;
    fence = copy.fence;
  }
}

}  // namespace

VKAPI_ATTR VkResult VKAPI_CALL present(VkQueue queue, const VkPresentInfoKHR* info) {
  DeviceData* d = device_of(queue);
  Head* head = memory();
  if (head == nullptr) return d->present(queue, info);
  std::uint32_t family = VK_QUEUE_FAMILY_IGNORED;
  {
    const ListsLocked locked;
    if (const QueueData* q = found(d->queues, [&](const QueueData& one) { return one.handle == queue; }))
      family = q->family;
  }
  VkPresentInfoKHR changed = *info;
  for (std::uint32_t i = 0; i < info->swapchainCount; ++i) {
    SwapchainData* s = swapchain_of(*d, info->pSwapchains[i]);
    if (s == nullptr) continue;
    // Those that were begun at an earlier picture (buffered).
    for (Copy& copy : s->copies)
      if (copy.busy && d->fence_status(d->handle, copy.fence) == VK_SUCCESS) hand_over(*head, *d, *s, copy);
    VkCommandBuffer commands[kMaxViews];
    std::uint32_t count = 0;
    VkFence last = VK_NULL_HANDLE;
    begin_copies(*head, *d, *s, info->pImageIndices[i], family, commands, kMaxViews, count, last);
    if (count == 0) continue;
    // The first copy waits for what the program draws; the presentation then waits for the copies. Of several copies
    // each has a fence, so each has a submission.
    bool begun = true;
    for (std::uint32_t c = 0; c < count && begun; ++c) {
      Copy* copy = nullptr;
      for (Copy& one : s->copies)
        if (one.busy && one.commands == commands[c]) copy = &one;
      VkPipelineStageFlags* stages = nullptr;
      VkSubmitInfo submit{};
      submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
      submit.commandBufferCount = 1, submit.pCommandBuffers = &commands[c];
      if (c == 0 && changed.waitSemaphoreCount > 0) {
        stages =
            static_cast<VkPipelineStageFlags*>(std::calloc(changed.waitSemaphoreCount, sizeof(VkPipelineStageFlags)));
        if (stages == nullptr) {
          begun = false;
          break;
        }
        for (std::uint32_t w = 0; w < changed.waitSemaphoreCount; ++w) stages[w] = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
        submit.waitSemaphoreCount = changed.waitSemaphoreCount;
        submit.pWaitSemaphores = changed.pWaitSemaphores;
        submit.pWaitDstStageMask = stages;
      }
      if (c + 1 == count)
        submit.signalSemaphoreCount = 1, submit.pSignalSemaphores = &s->copied[info->pImageIndices[i]];
      d->reset_fences(d->handle, 1, &copy->fence);
      begun = d->submit(queue, 1, &submit, copy->fence) == VK_SUCCESS;
      std::free(stages);
    }
    if (!begun) {  // the device is lost, or memory: the program hears that from its own calls
      for (Copy& copy : s->copies)
        if (copy.busy) refuse(*head, copy.job, AnswerStatus::lost), copy.busy = false;
      s->readable = false;
      continue;
    }
    changed.waitSemaphoreCount = 1, changed.pWaitSemaphores = &s->copied[info->pImageIndices[i]];
    if (reads_buffered()) continue;
    for (Copy& copy : s->copies) {
      if (!copy.busy) continue;
      if (d->wait_fences(d->handle, 1, &copy.fence, VK_TRUE, UINT64_MAX) == VK_SUCCESS)
        hand_over(*head, *d, *s, copy);
      else
        refuse(*head, copy.job, AnswerStatus::lost), copy.busy = false;
    }
  }
  return d->present(queue, &changed);
}

}  // namespace sinew::grab
