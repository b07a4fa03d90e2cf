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

// The calls of a driver `D`: constructed from a CreateInfo, with void write(const DisplayPixels&); both may throw.
template <class D>
struct DriverCalls {
  static void* create(const CreateInfo* info, ErrorText* error) {
    try {
      return new D(*info);
    } catch (const std::exception& e) {
      say(error, e.what());
      return nullptr;
    }
  }
  static void destroy(void* display) { delete static_cast<D*>(display); }
  static int write(void* display, const DisplayPixels* pixels, ErrorText* error) {
    try {
      static_cast<D*>(display)->write(*pixels);
      return 1;
    } catch (const std::exception& e) {
      return say(error, e.what());
    }
  }
};

}  // namespace kinora
