/* Preloaded before Octave: as many calls of sinew_copy() as OVERWRITE_COPIES says find their message overwritten. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "client/sinew_client.h"

int sinew_copy(const sinew_robot* robot, const sinew_message* message, void* into, size_t bytes) {
  int (*copy)(const sinew_robot*, const sinew_message*, void*, size_t);
  const char* left = getenv("OVERWRITE_COPIES");
  if (left && atoi(left) > 0) {
    char text[16];
    snprintf(text, sizeof text, "%d", atoi(left) - 1);
    setenv("OVERWRITE_COPIES", text, 1);
    return SINEW_OVERWRITTEN;
  }
  *(void**)&copy = dlsym(dlopen("libsinew_client.so.1", RTLD_LAZY | RTLD_NOLOAD), "sinew_copy");
  return copy(robot, message, into, bytes);
}
