#pragma once
// What the layer knows of a program: its instances, devices, queues and swapchains, in lists that one mutex guards. No
// allocation but calloc(): the program's C++ library is not ours.
#include <pthread.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "grab/preload/program_side.hpp"

namespace sinew::grab {

/// The loader's key of everything that belongs to one instance or device.
inline void* key_of(const void* dispatchable) noexcept { return *static_cast<void* const*>(dispatchable); }

/// VkXlibSurfaceCreateInfoKHR and VkXcbSurfaceCreateInfoKHR without the headers of X11.
struct XlibSurfaceInfo {
  VkStructureType type;
  const void* next;
  VkFlags flags;
  void* display;
  unsigned long window;
};
struct XcbSurfaceInfo {
  VkStructureType type;
  const void* next;
  VkFlags flags;
  void* connection;
  std::uint32_t window;
};
template <class Info>
using CreateSurface = VkResult(VKAPI_PTR*)(VkInstance, const Info*, const VkAllocationCallbacks*, VkSurfaceKHR*);

struct InstanceData {
  void* key;
  VkInstance handle;
  PFN_vkGetInstanceProcAddr next;
  PFN_vkDestroyInstance destroy;
  PFN_vkGetPhysicalDeviceMemoryProperties memory_properties;
  PFN_vkGetPhysicalDeviceQueueFamilyProperties family_properties;
  PFN_vkGetPhysicalDeviceSurfaceCapabilitiesKHR surface_capabilities;
  PFN_vkDestroySurfaceKHR destroy_surface;
  CreateSurface<XlibSurfaceInfo> create_xlib;  // null: the program did not ask for it, here and below
  CreateSurface<XcbSurfaceInfo> create_xcb;
  InstanceData* after;
};

struct QueueData {
  VkQueue handle;
  std::uint32_t family;
  QueueData* after;
};

/// What one picture needs while it is on its way. Made for a swapchain at the first picture that is asked for.
struct Copy {
  VkCommandBuffer commands;
  VkFence fence;
  VkBuffer buffer;
  VkDeviceMemory memory;
  VkDeviceSize bytes;
  const std::uint8_t* mapped;
  Job job;
  bool busy;
};

struct SwapchainData {
  VkSwapchainKHR handle;
  VkSurfaceKHR surface;
  VkFormat format;
  VkExtent2D extent;
  bool readable;
  std::uint32_t images_count;
  VkImage* images;
  VkSemaphore* copied;  // of each image: the copy is done, and it may be presented
  VkCommandPool pool;
  std::uint32_t pool_family;
  Copy copies[kMaxViews];
  SwapchainData* after;
};

struct DeviceData {
  void* key;
  VkDevice handle;
  VkPhysicalDevice physical;
  InstanceData* instance;
  PFN_vkSetDeviceLoaderData set_loader_data;
  PFN_vkGetDeviceProcAddr next;
  PFN_vkDestroyDevice destroy;
  PFN_vkGetDeviceQueue get_queue;
  PFN_vkGetDeviceQueue2 get_queue2;
  PFN_vkCreateSwapchainKHR create_swapchain;
  PFN_vkDestroySwapchainKHR destroy_swapchain;
  PFN_vkGetSwapchainImagesKHR swapchain_images;
  PFN_vkQueuePresentKHR present;
  PFN_vkQueueSubmit submit;
  PFN_vkCreateCommandPool create_pool;
  PFN_vkDestroyCommandPool destroy_pool;
  PFN_vkAllocateCommandBuffers allocate_commands;
  PFN_vkBeginCommandBuffer begin;
  PFN_vkEndCommandBuffer end;
  PFN_vkResetCommandBuffer reset;
  PFN_vkCmdPipelineBarrier barrier;
  PFN_vkCmdCopyImageToBuffer copy_image;
  PFN_vkCreateSemaphore create_semaphore;
  PFN_vkDestroySemaphore destroy_semaphore;
  PFN_vkCreateFence create_fence;
  PFN_vkDestroyFence destroy_fence;
  PFN_vkResetFences reset_fences;
  PFN_vkWaitForFences wait_fences;
  PFN_vkGetFenceStatus fence_status;
  PFN_vkCreateBuffer create_buffer;
  PFN_vkDestroyBuffer destroy_buffer;
  PFN_vkGetBufferMemoryRequirements buffer_requirements;
  PFN_vkAllocateMemory allocate_memory;
  PFN_vkFreeMemory free_memory;
  PFN_vkBindBufferMemory bind_memory;
  PFN_vkMapMemory map_memory;
  PFN_vkInvalidateMappedMemoryRanges invalidate;
  QueueData* queues;
  SwapchainData* swapchains;
  DeviceData* after;
};

extern pthread_mutex_t mutex_of_lists;
extern InstanceData* instances;
extern DeviceData* devices;

struct ListsLocked {
  ListsLocked() noexcept { pthread_mutex_lock(&mutex_of_lists); }
  ~ListsLocked() { pthread_mutex_unlock(&mutex_of_lists); }
  ListsLocked(const ListsLocked&) = delete;
  ListsLocked& operator=(const ListsLocked&) = delete;
};

template <class T>
T* made() noexcept {
  return static_cast<T*>(std::calloc(1, sizeof(T)));
}

template <class T, class Is>
T* found(T* list, Is&& is) noexcept {
  for (; list != nullptr; list = list->after)
    if (is(*list)) return list;
  return nullptr;
}

template <class T, class Is>
T* taken_out(T*& list, Is&& is) noexcept {
  for (T** at = &list; *at != nullptr; at = &(*at)->after) {
    if (!is(**at)) continue;
    T* out = *at;
    *at = out->after;
    return out;
  }
  return nullptr;
}

inline InstanceData* instance_of(const void* dispatchable) noexcept {
  const ListsLocked locked;
  return found(instances, [&](const InstanceData& d) { return d.key == key_of(dispatchable); });
}
inline DeviceData* device_of(const void* dispatchable) noexcept {
  const ListsLocked locked;
  return found(devices, [&](const DeviceData& d) { return d.key == key_of(dispatchable); });
}
inline SwapchainData* swapchain_of(DeviceData& device, VkSwapchainKHR handle) noexcept {
  const ListsLocked locked;
  return found(device.swapchains, [&](const SwapchainData& d) { return d.handle == handle; });
}

template <class Handle>
std::uint64_t number_of(Handle handle) noexcept {  // a pointer, or 64 bits where pointers have 32
  std::uint64_t number = 0;
  std::memcpy(&number, &handle, sizeof handle);
  return number;
}

// ---- swapchains and their pictures on the way (layer_copies.cpp)

/// False: a format that cannot be read.
bool order_of(VkFormat format, PixelOrder& order) noexcept;
void destroy_swapchain_data(DeviceData& d, SwapchainData* s) noexcept;
VKAPI_ATTR VkResult VKAPI_CALL create_swapchain(VkDevice device, const VkSwapchainCreateInfoKHR* info,
                                                const VkAllocationCallbacks* allocator, VkSwapchainKHR* swapchain);
VKAPI_ATTR void VKAPI_CALL destroy_swapchain(VkDevice device, VkSwapchainKHR swapchain,
                                             const VkAllocationCallbacks* allocator);
/// The images, and a semaphore for each. False: the driver refuses; the swapchain is not read then.
bool prepared(DeviceData& d, SwapchainData& s, std::uint32_t family) noexcept;
/// Commands and fence of a copy, its buffer as large as the picture.
bool ready(DeviceData& d, SwapchainData& s, Copy& copy) noexcept;
/// The commands that copy an image of the swapchain.
bool recorded(DeviceData& d, const SwapchainData& s, std::uint32_t image, const Copy& copy) noexcept;

// ---- present (layer_present.cpp)

VKAPI_ATTR VkResult VKAPI_CALL present(VkQueue queue, const VkPresentInfoKHR* info);

}  // namespace sinew::grab
