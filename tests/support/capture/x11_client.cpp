// SPDX-License-Identifier: Apache-2.0
#include "tests/support/capture/x11_client.hpp"

#include <X11/Xlib.h>
#include <X11/keysym.h>

namespace fringetwin::testing {
namespace {

// The topmost window of the first screen; 0 if there is none.
Window top_window(Display* display) {
  Window root = 0, parent = 0, *children = nullptr, top = 0;
  unsigned count = 0;
  if (XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count) && count > 0)
    top = children[count - 1];
  if (children) XFree(children);
  return top;
}

bool send(const std::string& display_name, long mask, XEvent (*make)(Display*, Window)) {
  Display* display = XOpenDisplay(display_name.c_str());
  if (!display) return false;
  const Window window = top_window(display);
  if (window) {
    XEvent event = make(display, window);
    XSendEvent(display, window, False, mask, &event);
    XSync(display, False);
  }
  XCloseDisplay(display);
  return window != 0;
}

}  // namespace

bool ask_window_to_close(const std::string& display_name) {
  return send(display_name, NoEventMask, [](Display* display, Window window) {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = window;
    event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "WM_DELETE_WINDOW", False));
    return event;
  });
}

bool press_escape(const std::string& display_name) {
  return send(display_name, KeyPressMask, [](Display* display, Window window) {
    XEvent event{};
    event.xkey.type = KeyPress;
    event.xkey.display = display;
    event.xkey.window = window;
    event.xkey.root = DefaultRootWindow(display);
    event.xkey.same_screen = True;
    event.xkey.keycode = XKeysymToKeycode(display, XK_Escape);
    return event;
  });
}

bool cover_and_uncover(const std::string& display_name) {
  Display* display = XOpenDisplay(display_name.c_str());
  if (!display) return false;
  XSetWindowAttributes attributes{};
  attributes.override_redirect = True;
  attributes.background_pixel = 0xff00ff;
  const Window over =
      XCreateWindow(display, DefaultRootWindow(display), 40, 30, 200, 100, 0, CopyFromParent, InputOutput,
                    CopyFromParent, CWOverrideRedirect | CWBackPixel, &attributes);
  XMapRaised(display, over);
  XSync(display, False);
  XDestroyWindow(display, over);
  XSync(display, False);
  XCloseDisplay(display);
  return true;
}

}  // namespace fringetwin::testing
