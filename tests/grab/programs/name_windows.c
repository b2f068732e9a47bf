/* name_windows TITLE: gives this title to every window of the display that has none. Debian's vkcube gives itself none. */
#include <X11/Xlib.h>

int main(int argc, char** argv) {
  Display* display = XOpenDisplay(NULL);
  Window root, parent, *all = NULL;
  unsigned count = 0, i;
  if (display == NULL || argc != 2) return 2;
  XQueryTree(display, DefaultRootWindow(display), &root, &parent, &all, &count);
  for (i = 0; i < count; ++i) {
    char* name = NULL;
    if (!XFetchName(display, all[i], &name)) XStoreName(display, all[i], argv[1]);
    if (name != NULL) XFree(name);
  }
  if (all != NULL) XFree(all);
  XCloseDisplay(display);
  return 0;
}
