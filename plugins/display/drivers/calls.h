// What display drivers share at the border to the renderer: exceptions become messages.
#pragma once
#include <kinora/display.h>

#include <cstdio>
#include <exception>

namespace kinora {

// Fills in the message of a failed call and returns what such a call returns.
inline int say(ErrorText* error, const char* what) {
  std::snprintf(error->text, sizeof error->text, "%s", what);
  return 0;
}

// The calls of a driver `D`: constructed from a CreateInfo and its DisplayInfo, with void write(const DisplayPixels&)
// and void close(); all may throw.
template <class D>
struct DriverCalls {
  static void* create(const CreateInfo* info, ErrorText* error) {
    try {
      return new D(*info, *static_cast<const DisplayInfo*>(info->extra));
    } catch (const std::exception& e) {
      say(error, e.what());
      return nullptr;
    }
  }
  static void destroy(void* display) { delete static_cast<D*>(display); }
  template <class Run>
  static int guarded(ErrorText* error, Run run) {
    try {
      run();
      return 1;
    } catch (const std::exception& e) {
      return say(error, e.what());
    }
  }
  static int write(void* display, const DisplayPixels* pixels, ErrorText* error) {
    return guarded(error, [&] { static_cast<D*>(display)->write(*pixels); });
  }
  static int close(void* display, ErrorText* error) {
    return guarded(error, [&] { static_cast<D*>(display)->close(); });
  }
  static void abort(void*) {}  // destroy() forgets the picture
  static constexpr DisplayFunctions kFunctions{write, close, abort};
};

}  // namespace kinora
