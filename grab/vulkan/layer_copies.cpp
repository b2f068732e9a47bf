// Swapchains that can be read, and what copies a picture out of one.
#include "grab/vulkan/layer_data.hpp"

namespace sinew::grab {
namespace {

void destroy_buffer(DeviceData& d, Copy& copy) noexcept {
  if (copy.buffer != VK_NULL_HANDLE) d.destroy_buffer(d.handle, copy.buffer, nullptr);
  if (copy.memory != VK_NULL_HANDLE) d.free_memory(d.handle, copy.memory, nullptr);  // unmaps it
  copy.buffer = VK_NULL_HANDLE, copy.memory = VK_NULL_HANDLE, copy.mapped = nullptr, copy.bytes = 0;
}

/// Memory that the processor reads fast, if there is such.
bool memory_type_of(DeviceData& d, std::uint32_t allowed, std::uint32_t& type) noexcept {
  VkPhysicalDeviceMemoryProperties properties{};
  d.instance->memory_properties(d.physical, &properties);
  const VkMemoryPropertyFlags visible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  for (const VkMemoryPropertyFlags wanted : {visible | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, visible})
    for (std::uint32_t i = 0; i < properties.memoryTypeCount; ++i)
      if ((allowed >> i & 1) != 0 && (properties.memoryTypes[i].propertyFlags & wanted) == wanted) {
        type = i;
        return true;
      }
  return false;
}

bool room_for(DeviceData& d, Copy& copy, VkDeviceSize bytes) noexcept {
  if (copy.bytes >= bytes) return true;
  destroy_buffer(d, copy);
  VkBufferCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = bytes, info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  if (d.create_buffer(d.handle, &info, nullptr, &copy.buffer) != VK_SUCCESS) return false;
  VkMemoryRequirements needs{};
  d.buffer_requirements(d.handle, copy.buffer, &needs);
  VkMemoryAllocateInfo allocate{};
  allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  allocate.allocationSize = needs.size;
  void* at = nullptr;
  if (!memory_type_of(d, needs.memoryTypeBits, allocate.memoryTypeIndex) ||
      d.allocate_memory(d.handle, &allocate, nullptr, &copy.memory) != VK_SUCCESS ||
      d.bind_memory(d.handle, copy.buffer, copy.memory, 0) != VK_SUCCESS ||
      d.map_memory(d.handle, copy.memory, 0, VK_WHOLE_SIZE, 0, &at) != VK_SUCCESS) {
    destroy_buffer(d, copy);
    return false;
  }
  copy.mapped = static_cast<const std::uint8_t*>(at), copy.bytes = bytes;
  return true;
}

}  // namespace

bool order_of(VkFormat format, PixelOrder& order) noexcept {
  switch (format) {
    case VK_FORMAT_B8G8R8A8_UNORM:
    case VK_FORMAT_B8G8R8A8_SRGB:
      order = PixelOrder::bgrx;
      return true;
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SRGB:
    case VK_FORMAT_A8B8G8R8_UNORM_PACK32:  // the same bytes on a machine with the lowest byte first
    case VK_FORMAT_A8B8G8R8_SRGB_PACK32:
      order = PixelOrder::rgbx;
      return true;
    default:
      return false;
  }
}

VKAPI_ATTR VkResult VKAPI_CALL create_swapchain(VkDevice device, const VkSwapchainCreateInfoKHR* info,
                                                const VkAllocationCallbacks* allocator, VkSwapchainKHR* swapchain) {
  DeviceData* d = device_of(device);
  VkSwapchainCreateInfoKHR with_source = *info;
  VkSurfaceCapabilitiesKHR capabilities{};
  PixelOrder order{};
  bool readable = memory() != nullptr && order_of(info->imageFormat, order) &&
                  d->instance->surface_capabilities != nullptr &&
                  d->instance->surface_capabilities(d->physical, info->surface, &capabilities) == VK_SUCCESS &&
                  (capabilities.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_SRC_BIT) != 0;
  VkResult result = VK_ERROR_UNKNOWN;
  if (readable) {
    with_source.imageUsage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    result = d->create_swapchain(device, &with_source, allocator, swapchain);
    readable = result == VK_SUCCESS;
  }
  if (!readable) result = d->create_swapchain(device, info, allocator, swapchain);
  if (result != VK_SUCCESS) return result;
  auto* s = made<SwapchainData>();
  if (s == nullptr) return result;  // its pictures are not seen
  s->handle = *swapchain, s->surface = info->surface, s->format = info->imageFormat, s->extent = info->imageExtent;
  s->readable = readable;
  s->pool_family = VK_QUEUE_FAMILY_IGNORED;
  const ListsLocked locked;
  s->after = d->swapchains, d->swapchains = s;
  return result;
}

VKAPI_ATTR void VKAPI_CALL destroy_swapchain(VkDevice device, VkSwapchainKHR swapchain,
                                             const VkAllocationCallbacks* allocator) {
  DeviceData* d = device_of(device);
  SwapchainData* s;
  {
    const ListsLocked locked;
    s = taken_out(d->swapchains, [&](const SwapchainData& one) { return one.handle == swapchain; });
  }
  if (s != nullptr) destroy_swapchain_data(*d, s);
  d->destroy_swapchain(device, swapchain, allocator);
}

/// Waits for what the device still does with it. The program destroys a swapchain after its own work has ended; ours is
/// shorter.
void destroy_swapchain_data(DeviceData& d, SwapchainData* s) noexcept {
  for (Copy& copy : s->copies) {
    if (copy.busy) {
      d.wait_fences(d.handle, 1, &copy.fence, VK_TRUE, UINT64_MAX);
      if (Head* head = memory()) refuse(*head, copy.job, AnswerStatus::lost);
    }
    destroy_buffer(d, copy);
    if (copy.fence != VK_NULL_HANDLE) d.destroy_fence(d.handle, copy.fence, nullptr);
  }
  if (s->copied != nullptr)
    for (std::uint32_t i = 0; i < s->images_count; ++i)
      if (s->copied[i] != VK_NULL_HANDLE) d.destroy_semaphore(d.handle, s->copied[i], nullptr);
  if (s->pool != VK_NULL_HANDLE) d.destroy_pool(d.handle, s->pool, nullptr);
  std::free(s->copied);
  std::free(s->images);
  std::free(s);
}

bool prepared(DeviceData& d, SwapchainData& s, std::uint32_t family) noexcept {
  if (s.images == nullptr) {
    std::uint32_t count = 0;
    if (d.swapchain_images(d.handle, s.handle, &count, nullptr) != VK_SUCCESS || count == 0) return false;
    s.images = static_cast<VkImage*>(std::calloc(count, sizeof(VkImage)));
    s.copied = static_cast<VkSemaphore*>(std::calloc(count, sizeof(VkSemaphore)));
    if (s.images == nullptr || s.copied == nullptr ||
        d.swapchain_images(d.handle, s.handle, &count, s.images) != VK_SUCCESS)
      return false;
    s.images_count = count;
    VkSemaphoreCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
    for (std::uint32_t i = 0; i < count; ++i)
      if (d.create_semaphore(d.handle, &info, nullptr, &s.copied[i]) != VK_SUCCESS) return false;
  }
  if (s.pool == VK_NULL_HANDLE) {
    VkCommandPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    info.queueFamilyIndex = family;
    if (d.create_pool(d.handle, &info, nullptr, &s.pool) != VK_SUCCESS) return false;
    s.pool_family = family;
  }
  return s.pool_family == family;  // a program that presents from two families is seen on the first
}

bool ready(DeviceData& d, SwapchainData& s, Copy& copy) noexcept {
  if (copy.commands == VK_NULL_HANDLE) {
    VkCommandBufferAllocateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    info.commandPool = s.pool, info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY, info.commandBufferCount = 1;
    if (d.allocate_commands(d.handle, &info, &copy.commands) != VK_SUCCESS) return false;
    // What a layer makes lacks what the loader puts in for the program.
    if (d.set_loader_data == nullptr || d.set_loader_data(d.handle, copy.commands) != VK_SUCCESS)
      *reinterpret_cast<void**>(copy.commands) = key_of(d.handle);
  }
  if (copy.fence == VK_NULL_HANDLE) {
    VkFenceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    if (d.create_fence(d.handle, &info, nullptr, &copy.fence) != VK_SUCCESS) return false;
  }
  return room_for(d, copy, VkDeviceSize{copy.job.answer.stride} * copy.job.answer.height);
}

bool recorded(DeviceData& d, const SwapchainData& s, std::uint32_t image, const Copy& copy) noexcept {
  VkCommandBufferBeginInfo begin{};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  if (d.reset(copy.commands, 0) != VK_SUCCESS || d.begin(copy.commands, &begin) != VK_SUCCESS) return false;
  VkImageMemoryBarrier image_barrier{};
  image_barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
  image_barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT, image_barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
  image_barrier.oldLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
  image_barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
  image_barrier.srcQueueFamilyIndex = image_barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  image_barrier.image = s.images[image];
  image_barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  d.barrier(copy.commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0,
            nullptr, 1, &image_barrier);
  const Answer& a = copy.job.answer;
  VkBufferImageCopy region{};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageOffset = {a.x, a.y, 0};
  region.imageExtent = {a.width, a.height, 1};
  d.copy_image(copy.commands, s.images[image], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, copy.buffer, 1, &region);
  image_barrier.srcAccessMask = VK_ACCESS_TRANSFER_READ_BIT, image_barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT;
  image_barrier.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
  image_barrier.newLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
  VkBufferMemoryBarrier buffer_barrier{};
  buffer_barrier.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER;
  buffer_barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT, buffer_barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
  buffer_barrier.srcQueueFamilyIndex = buffer_barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  buffer_barrier.buffer = copy.buffer, buffer_barrier.size = VK_WHOLE_SIZE;
  d.barrier(copy.commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
            VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 0, nullptr, 1, &buffer_barrier, 1,
            &image_barrier);
  return d.end(copy.commands) == VK_SUCCESS;
}

}  // namespace sinew::grab
