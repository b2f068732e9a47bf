// VK_LAYER_SINEW_grab: sees the pictures that a program presents. Between the program and its driver stand instance,
// device, swapchain and vkQueuePresentKHR; everything else passes unseen. A picture that is asked for is copied out of
// the swapchain's image by one submission to the queue that presents it.
#include "grab/vulkan/layer_data.hpp"

#define SINEW_EXPORTED extern "C" __attribute__((visibility("default")))

namespace sinew::grab {

pthread_mutex_t mutex_of_lists = PTHREAD_MUTEX_INITIALIZER;
InstanceData* instances = nullptr;
DeviceData* devices = nullptr;

namespace {

// ---- instance and device

/// The loader's element of the chain: where the next layer is. Null: the loader did not call us.
template <class Info, class Create>
Info* link_of(const Create* create, VkStructureType type, VkLayerFunction function) noexcept {
  for (auto* at = static_cast<const VkBaseInStructure*>(create->pNext); at != nullptr; at = at->pNext) {
    if (at->sType != type) continue;
    auto* info = reinterpret_cast<Info*>(const_cast<VkBaseInStructure*>(at));
    if (info->function == function) return info;
  }
  return nullptr;
}

VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                               VkInstance* instance) {
  auto* link =
      link_of<VkLayerInstanceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO, VK_LAYER_LINK_INFO);
  if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  const PFN_vkGetInstanceProcAddr next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;  // for the next layer
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(next(VK_NULL_HANDLE, "vkCreateInstance"));
  if (create == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  const VkResult result = create(info, allocator, instance);
  if (result != VK_SUCCESS) return result;
  auto* data = made<InstanceData>();
  if (data == nullptr) return VK_ERROR_OUT_OF_HOST_MEMORY;
  data->key = key_of(*instance), data->handle = *instance, data->next = next;
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(next(*instance, name));
  };
  find(data->destroy, "vkDestroyInstance");
  find(data->memory_properties, "vkGetPhysicalDeviceMemoryProperties");
  find(data->family_properties, "vkGetPhysicalDeviceQueueFamilyProperties");
  find(data->surface_capabilities, "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  find(data->destroy_surface, "vkDestroySurfaceKHR");
  find(data->create_xlib, "vkCreateXlibSurfaceKHR");
  find(data->create_xcb, "vkCreateXcbSurfaceKHR");
  const ListsLocked locked;
  data->after = instances, instances = data;
  return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroy_instance(VkInstance instance, const VkAllocationCallbacks* allocator) {
  if (instance == VK_NULL_HANDLE) return;
  InstanceData* data;
  {
    const ListsLocked locked;
    data = taken_out(instances, [&](const InstanceData& d) { return d.key == key_of(instance); });
  }
  if (data == nullptr) return;
  data->destroy(instance, allocator);
  std::free(data);
}

template <class Info, CreateSurface<Info> InstanceData::*Next>
VKAPI_ATTR VkResult VKAPI_CALL create_surface(VkInstance instance, const Info* info,
                                              const VkAllocationCallbacks* allocator, VkSurfaceKHR* surface) {
  InstanceData* data = instance_of(instance);
  if (data == nullptr || data->*Next == nullptr) return VK_ERROR_EXTENSION_NOT_PRESENT;
  const VkResult result = (data->*Next)(instance, info, allocator, surface);
  if (result == VK_SUCCESS) note_x11_window(Api::vulkan, nullptr, number_of(*surface), info->window);
  return result;
}

VKAPI_ATTR void VKAPI_CALL destroy_surface(VkInstance instance, VkSurfaceKHR surface,
                                           const VkAllocationCallbacks* allocator) {
  InstanceData* data = instance_of(instance);
  if (data == nullptr || data->destroy_surface == nullptr) return;
  forget_window(Api::vulkan, nullptr, number_of(surface));
  data->destroy_surface(instance, surface, allocator);
}

VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                             const VkAllocationCallbacks* allocator, VkDevice* device) {
  auto* link = link_of<VkLayerDeviceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO, VK_LAYER_LINK_INFO);
  InstanceData* instance = instance_of(physical);
  if (link == nullptr || instance == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  const PFN_vkGetInstanceProcAddr next_instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  const PFN_vkGetDeviceProcAddr next = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto* loader =
      link_of<VkLayerDeviceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO, VK_LOADER_DATA_CALLBACK);
  const auto create = reinterpret_cast<PFN_vkCreateDevice>(next_instance(instance->handle, "vkCreateDevice"));
  if (create == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  const VkResult result = create(physical, info, allocator, device);
  if (result != VK_SUCCESS) return result;
  auto* d = made<DeviceData>();
  if (d == nullptr) return VK_ERROR_OUT_OF_HOST_MEMORY;
  d->key = key_of(*device), d->handle = *device, d->physical = physical, d->instance = instance, d->next = next;
  d->set_loader_data = loader != nullptr ? loader->u.pfnSetDeviceLoaderData : nullptr;
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(next(*device, name));
  };
  find(d->destroy, "vkDestroyDevice");
  find(d->get_queue, "vkGetDeviceQueue");
  find(d->get_queue2, "vkGetDeviceQueue2");
  find(d->create_swapchain, "vkCreateSwapchainKHR");
  find(d->destroy_swapchain, "vkDestroySwapchainKHR");
  find(d->swapchain_images, "vkGetSwapchainImagesKHR");
  find(d->present, "vkQueuePresentKHR");
  find(d->submit, "vkQueueSubmit");
  find(d->create_pool, "vkCreateCommandPool");
  find(d->destroy_pool, "vkDestroyCommandPool");
  find(d->allocate_commands, "vkAllocateCommandBuffers");
  find(d->begin, "vkBeginCommandBuffer");
  find(d->end, "vkEndCommandBuffer");
  find(d->reset, "vkResetCommandBuffer");
  find(d->barrier, "vkCmdPipelineBarrier");
  find(d->copy_image, "vkCmdCopyImageToBuffer");
  find(d->create_semaphore, "vkCreateSemaphore");
  find(d->destroy_semaphore, "vkDestroySemaphore");
  find(d->create_fence, "vkCreateFence");
  find(d->destroy_fence, "vkDestroyFence");
  find(d->reset_fences, "vkResetFences");
  find(d->wait_fences, "vkWaitForFences");
  find(d->fence_status, "vkGetFenceStatus");
  find(d->create_buffer, "vkCreateBuffer");
  find(d->destroy_buffer, "vkDestroyBuffer");
  find(d->buffer_requirements, "vkGetBufferMemoryRequirements");
  find(d->allocate_memory, "vkAllocateMemory");
  find(d->free_memory, "vkFreeMemory");
  find(d->bind_memory, "vkBindBufferMemory");
  find(d->map_memory, "vkMapMemory");
  find(d->invalidate, "vkInvalidateMappedMemoryRanges");
  const ListsLocked locked;
  d->after = devices, devices = d;
  return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroy_device(VkDevice device, const VkAllocationCallbacks* allocator) {
  if (device == VK_NULL_HANDLE) return;
  DeviceData* d;
  {
    const ListsLocked locked;
    d = taken_out(devices, [&](const DeviceData& one) { return one.key == key_of(device); });
  }
  if (d == nullptr) return;
  while (d->swapchains != nullptr) {
    SwapchainData* s = d->swapchains;
    d->swapchains = s->after;
    destroy_swapchain_data(*d, s);
  }
  while (d->queues != nullptr) {
    QueueData* q = d->queues;
    d->queues = q->after;
    std::free(q);
  }
  d->destroy(device, allocator);
  std::free(d);
}

void remember_queue(DeviceData& d, VkQueue queue, std::uint32_t family) noexcept {
  if (queue == VK_NULL_HANDLE) return;
  const ListsLocked locked;
  if (found(d.queues, [&](const QueueData& q) { return q.handle == queue; }) != nullptr) return;
  auto* data = made<QueueData>();
  if (data == nullptr) return;
  data->handle = queue, data->family = family;
  data->after = d.queues, d.queues = data;
}

VKAPI_ATTR void VKAPI_CALL get_queue(VkDevice device, std::uint32_t family, std::uint32_t index, VkQueue* queue) {
  DeviceData* d = device_of(device);
  d->get_queue(device, family, index, queue);
  remember_queue(*d, *queue, family);
}

VKAPI_ATTR void VKAPI_CALL get_queue2(VkDevice device, const VkDeviceQueueInfo2* info, VkQueue* queue) {
  DeviceData* d = device_of(device);
  d->get_queue2(device, info, queue);
  remember_queue(*d, *queue, info->queueFamilyIndex);
}

// ---- what the loader asks for

struct Named {
  const char* name;
  PFN_vkVoidFunction function;
};

template <class F>
PFN_vkVoidFunction any(F* function) noexcept {
  return reinterpret_cast<PFN_vkVoidFunction>(function);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_function(VkDevice device, const char* name);
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_function(VkInstance instance, const char* name);

PFN_vkVoidFunction of_device(const char* name) noexcept {
  const Named ours[] = {{"vkGetDeviceProcAddr", any(device_function)},
                        {"vkDestroyDevice", any(destroy_device)},
                        {"vkGetDeviceQueue", any(get_queue)},
                        {"vkGetDeviceQueue2", any(get_queue2)},
                        {"vkCreateSwapchainKHR", any(create_swapchain)},
                        {"vkDestroySwapchainKHR", any(destroy_swapchain)},
                        {"vkQueuePresentKHR", any(present)}};
  for (const Named& n : ours)
    if (std::strcmp(n.name, name) == 0) return n.function;
  return nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_function(VkDevice device, const char* name) {
  DeviceData* d = device_of(device);
  if (d == nullptr) return nullptr;
  PFN_vkVoidFunction next = d->next(device, name);
  const PFN_vkVoidFunction ours = of_device(name);
  return next != nullptr && ours != nullptr ? ours : next;  // what the device lacks, we lack
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_function(VkInstance instance, const char* name) {
  const Named ours[] = {{"vkGetInstanceProcAddr", any(instance_function)},
                        {"vkCreateInstance", any(create_instance)},
                        {"vkDestroyInstance", any(destroy_instance)},
                        {"vkCreateDevice", any(create_device)},
                        {"vkDestroySurfaceKHR", any(destroy_surface)}};
  for (const Named& n : ours)
    if (std::strcmp(n.name, name) == 0) return n.function;
  if (const PFN_vkVoidFunction function = of_device(name)) return function;
  if (instance == VK_NULL_HANDLE) return nullptr;
  InstanceData* data = instance_of(instance);
  if (data == nullptr) return nullptr;
  if (std::strcmp(name, "vkCreateXlibSurfaceKHR") == 0 && data->create_xlib != nullptr)
    return any(create_surface<XlibSurfaceInfo, &InstanceData::create_xlib>);
  if (std::strcmp(name, "vkCreateXcbSurfaceKHR") == 0 && data->create_xcb != nullptr)
    return any(create_surface<XcbSurfaceInfo, &InstanceData::create_xcb>);
  return data->next(instance, name);
}

}  // namespace
}  // namespace sinew::grab

SINEW_EXPORTED VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* interface) {
  constexpr std::uint32_t kOurs = 2;
  if (interface == nullptr || interface->sType != LAYER_NEGOTIATE_INTERFACE_STRUCT)
    return VK_ERROR_INITIALIZATION_FAILED;
  if (interface->loaderLayerInterfaceVersion < kOurs) return VK_ERROR_INITIALIZATION_FAILED;
  interface->loaderLayerInterfaceVersion = kOurs;
  interface->pfnGetInstanceProcAddr = sinew::grab::instance_function;
  interface->pfnGetDeviceProcAddr = sinew::grab::device_function;
  interface->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}
