// SPDX-License-Identifier: Apache-2.0
// The module on SDL2. SDL wants one thread for all its windows; it has it here, so that windows answer the
// desktop and repaint while the program waits for cameras.
#include "capture/display/window_module.hpp"

#include <SDL.h>
#include <SDL_syswm.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include "twin/base/not_copyable.hpp"

namespace fringetwin::capture {
namespace {

constexpr const char* kDesktopEndedFault = "the desktop has ended";

// One window and its texture. Lives on SDL's thread but for closed().
struct SdlWindow : NotCopyable {
  SDL_Window* window = nullptr;
  SDL_Renderer* renderer = nullptr;
  SDL_Texture* texture = nullptr;
  int width = 0, height = 0;
  std::atomic<bool> closed = false;

  ~SdlWindow() {
    if (texture) SDL_DestroyTexture(texture);
    if (renderer) SDL_DestroyRenderer(renderer);
    if (window) SDL_DestroyWindow(window);
  }
  bool paint() {
    return SDL_RenderCopy(renderer, texture, nullptr, nullptr) == 0 && (SDL_RenderPresent(renderer), true);
  }
};

// Ours only where the environment says nothing (SDL_RENDER_DRIVER=opengl, ...).
void set_hints() {
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");  // Ctrl-C stays the program's
  SDL_SetHintWithPriority(SDL_HINT_RENDER_DRIVER, "software", SDL_HINT_DEFAULT);
  SDL_SetHintWithPriority(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0", SDL_HINT_DEFAULT);
  SDL_SetHint(SDL_HINT_RENDER_SCALE_QUALITY, "nearest");
  SDL_SetHint(SDL_HINT_VIDEO_MINIMIZE_ON_FOCUS_LOSS, "0");  // the terminal has the focus
  SDL_SetHint(SDL_HINT_VIDEO_ALLOW_SCREENSAVER, "0");
}

bool means_close(const SDL_Event& event) {
  return (event.type == SDL_WINDOWEVENT && event.window.event == SDL_WINDOWEVENT_CLOSE) ||
         (event.type == SDL_KEYDOWN && event.key.keysym.sym == SDLK_ESCAPE);
}

class SdlThread : NotCopyable {
 public:
  /// The X server's end: Xlib would end the program, or return into SDL, which then never comes back.
  static std::atomic<bool> desktop_ended;

  SdlThread() : thread_([this] { loop(); }) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return started_; });
  }
  ~SdlThread() {
    if (run([this] { ended_ = true; }))
      thread_.join();
    else
      thread_.detach();
  }

  const std::string& fault() const { return fault_; }
  /// Runs the job on SDL's thread and returns when it is done; false if the desktop has ended. Jobs do not
  /// throw.
  bool run(const std::function<void()>& job) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return job_ == nullptr || desktop_ended; });
    if (desktop_ended) return false;
    job_ = &job;
    changed_.notify_all();
    changed_.wait(lock, [&] { return job_ == nullptr || desktop_ended; });
    return !desktop_ended;
  }
  void watch_connection(SDL_Window* window);

  std::map<Uint32, SdlWindow*> windows;  ///< SDL's thread only

 private:
  void loop();
  void pump();
  static int park(Display*);

  std::mutex mutex_;
  std::condition_variable changed_;
  bool started_ = false, ended_ = false;
  const std::function<void()>* job_ = nullptr;
  std::string fault_;
  std::thread thread_;
};

std::atomic<bool> SdlThread::desktop_ended = false;

// Of one display; there is one SdlThread at a time.
static SdlThread* watched = nullptr;

int SdlThread::park(Display*) {
  {
    const std::lock_guard lock(watched->mutex_);
    desktop_ended = true;
    watched->changed_.notify_all();
  }
  for (;;) ::pause();
}

void SdlThread::watch_connection(SDL_Window* window) {
  SDL_SysWMinfo info;
  SDL_VERSION(&info.version);
  if (!SDL_GetWindowWMInfo(window, &info) || info.subsystem != SDL_SYSWM_X11) return;
  watched = this;
  XSetIOErrorHandler(park);
}

void SdlThread::loop() {
  std::unique_lock lock(mutex_);
  set_hints();
  if (SDL_Init(SDL_INIT_VIDEO) != 0)
    fault_ = SDL_GetError();
  else if (const std::string driver = SDL_GetCurrentVideoDriver(); driver == "offscreen" || driver == "dummy")
    fault_ = "neither DISPLAY nor WAYLAND_DISPLAY names one";  // SDL would draw into memory that nobody sees
  if (fault_.empty()) SDL_DisableScreenSaver();
  started_ = true;
  changed_.notify_all();
  while (!ended_) {
    // Often enough for a desktop not to call the window dead, and for a repaint not to be noticed.
    changed_.wait_for(lock, std::chrono::milliseconds(5), [&] { return job_ != nullptr; });
    const std::function<void()>* job = job_;
    lock.unlock();
    if (fault_.empty()) pump();
    if (job) (*job)();
    lock.lock();
    if (!job) continue;
    job_ = nullptr;
    changed_.notify_all();
  }
  SDL_Quit();
}

void SdlThread::pump() {
  for (SDL_Event event; SDL_PollEvent(&event);) {
    if (event.type == SDL_QUIT)
      for (const auto& [id, window] : windows) window->closed = true;
    if (event.type != SDL_WINDOWEVENT && event.type != SDL_KEYDOWN) continue;
    const auto found = windows.find(event.window.windowID);  // at the same place in both events
    if (found == windows.end()) continue;
    if (means_close(event)) found->second->closed = true;
    if (event.type == SDL_WINDOWEVENT && event.window.event == SDL_WINDOWEVENT_EXPOSED)
      found->second->paint();
  }
}

// A desktop makes a window full-screen when it likes to; until then its size is another.
void wait_for_full_screen(const SDL_Rect& bounds, SDL_Window* window, SDL_Renderer* renderer, int* width,
                          int* height) {
  for (int tries = 0; tries < 100; ++tries) {
    SDL_PumpEvents();
    int w = 0, h = 0;
    SDL_GetWindowSize(window, &w, &h);
    SDL_GetRendererOutputSize(renderer, width, height);
    if (w == bounds.w && h == bounds.h) return;
    SDL_Delay(10);
  }
}

bool create(SdlWindow* out, int screen, std::string* description) {
  if (screen >= SDL_GetNumVideoDisplays()) {
    SDL_SetError("there is no screen %d: the desktop has %d", screen, SDL_GetNumVideoDisplays());
    return false;
  }
  SDL_Rect bounds{};
  if (SDL_GetDisplayBounds(screen, &bounds) != 0) return false;
  out->window =
      SDL_CreateWindow("fringetwin", bounds.x, bounds.y, bounds.w, bounds.h,
                       SDL_WINDOW_FULLSCREEN_DESKTOP | SDL_WINDOW_BORDERLESS | SDL_WINDOW_ALLOW_HIGHDPI);
  if (!out->window) return false;
  out->renderer = SDL_CreateRenderer(out->window, -1, SDL_RENDERER_PRESENTVSYNC);
  if (!out->renderer) out->renderer = SDL_CreateRenderer(out->window, -1, 0);
  if (!out->renderer) return false;
  SDL_ShowCursor(SDL_DISABLE);
  SDL_RaiseWindow(out->window);
  wait_for_full_screen(bounds, out->window, out->renderer, &out->width, &out->height);
  if (const int there = SDL_GetWindowDisplayIndex(out->window); there != screen) {
    SDL_SetError("the desktop put it on screen %d", there);
    return false;
  }
  out->texture = SDL_CreateTexture(out->renderer, SDL_PIXELFORMAT_ARGB8888, SDL_TEXTUREACCESS_STREAMING,
                                   out->width, out->height);
  if (!out->texture) return false;
  SDL_SetTextureBlendMode(out->texture, SDL_BLENDMODE_NONE);
  SDL_RendererInfo info{};
  SDL_GetRendererInfo(out->renderer, &info);
  const char* name = SDL_GetDisplayName(screen);
  *description = fmt::format("SDL2 {} {} on {}", SDL_GetCurrentVideoDriver(), info.name ? info.name : "?",
                             name ? name : "?");
  return true;
}

bool paint_image(SdlWindow* window, const ImageU8& gray) {
  void* pixels = nullptr;
  int pitch = 0;
  if (SDL_LockTexture(window->texture, nullptr, &pixels, &pitch) != 0) return false;
  for (int y = 0; y < gray.height; ++y) {
    auto* row =
        reinterpret_cast<Uint32*>(static_cast<Uint8*>(pixels) + static_cast<std::ptrdiff_t>(y) * pitch);
    for (int x = 0; x < gray.width; ++x) row[x] = 0xff000000U | gray(x, y) * 0x010101U;
  }
  SDL_UnlockTexture(window->texture);
  return window->paint();
}

class SharedWindow : public Window {
 public:
  explicit SharedWindow(std::shared_ptr<SdlThread> sdl) : sdl_(std::move(sdl)) {}
  ~SharedWindow() override {
    if (!sdl_->run([this] {
          sdl_->windows.erase(id_);
          window_.reset();
        }))
      (void)window_.release();  // SDL's thread stands still
  }

  bool open(int screen, std::string* fault) {
    sdl_->run([&] {
      window_ = std::make_unique<SdlWindow>();
      const bool opened = create(window_.get(), screen, &description_) &&
                          paint_image(window_.get(), ImageU8(window_->width, window_->height));
      if (!opened) {
        *fault = SDL_GetError();
        return;
      }
      sdl_->watch_connection(window_->window);
      id_ = SDL_GetWindowID(window_->window);
      sdl_->windows[id_] = window_.get();
    });
    return id_ != 0;
  }
  int width() const override { return window_->width; }
  int height() const override { return window_->height; }
  std::string description() const override { return description_; }
  bool closed() const override { return window_->closed; }
  bool gone() const override { return SdlThread::desktop_ended; }
  bool present(const ImageU8& gray, std::string* fault) override {
    bool shown = false;
    const bool done = sdl_->run([&] {
      int width = 0, height = 0;
      if (SDL_GetRendererOutputSize(window_->renderer, &width, &height) != 0)
        *fault = SDL_GetError();
      else if (width != gray.width || height != gray.height)
        *fault = fmt::format("the window is now {}x{} pixels", width, height);
      else if (shown = paint_image(window_.get(), gray); !shown)
        *fault = SDL_GetError();
    });
    if (!done) *fault = kDesktopEndedFault;
    return done && shown;
  }

 private:
  std::shared_ptr<SdlThread> sdl_;
  std::unique_ptr<SdlWindow> window_;
  Uint32 id_ = 0;  ///< SDL's, from 1
  std::string description_;
};

class SdlModule : public WindowModule {
 public:
  std::vector<Screen> screens(std::string* fault) override {
    std::vector<Screen> screens;
    const auto sdl = thread(fault);
    if (sdl)
      sdl->run([&] {
        for (int i = 0; i < SDL_GetNumVideoDisplays(); ++i) {
          SDL_DisplayMode mode{};
          const char* name = SDL_GetDisplayName(i);
          if (SDL_GetDesktopDisplayMode(i, &mode) == 0)
            screens.push_back({name ? name : "?", mode.w, mode.h, mode.refresh_rate});
        }
      });
    return screens;
  }
  std::unique_ptr<Window> open(int screen, std::string* fault) override {
    auto sdl = thread(fault);
    if (!sdl) return nullptr;
    auto window = std::make_unique<SharedWindow>(std::move(sdl));
    if (!window->open(screen, fault)) return nullptr;
    return window;
  }

 private:
  std::shared_ptr<SdlThread> thread(std::string* fault) {
    if (SdlThread::desktop_ended) {
      *fault = kDesktopEndedFault;
      return nullptr;
    }
    auto sdl = thread_.lock();
    if (!sdl) thread_ = sdl = std::make_shared<SdlThread>();
    if (sdl->fault().empty()) return sdl;
    *fault = sdl->fault();
    return nullptr;
  }
  std::weak_ptr<SdlThread> thread_;
};

}  // namespace
}  // namespace fringetwin::capture

extern "C" fringetwin::capture::WindowModule* fringetwin_window_module_1() {
  static fringetwin::capture::SdlModule module;
  return &module;
}
