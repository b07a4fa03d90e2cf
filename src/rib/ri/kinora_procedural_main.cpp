// kinora-procedural OBJECT [DATA]: runs a shared object of Procedural "DynamicLoad" and prints the RIB of what it calls
// (include/kinora/ri.h). Kinora starts it where scenes may run programs (--allow-exec): what an object does to this
// process it does to no picture. By hand it makes an archive of a procedural.
#include <dlfcn.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <iostream>
#include <iterator>

#include "base/digest.h"
#include "rib/ri/stream.h"

namespace {

int fail(const std::string& why) {
  std::cerr << "kinora-procedural: " << why << std::endl;
  return 1;
}

template <class Function>
Function functionOf(void* object, const char* name) {
  return reinterpret_cast<Function>(dlsym(object, name));
}

int run(const std::string& object, std::string data, double detail, const std::vector<float>& bound) {
  // what the object prints is not RIB
  std::FILE* out = fdopen(dup(STDOUT_FILENO), "w");
  if (!out || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) return fail("standard output cannot be used");
  kinora::rib::ri::Stream& stream = kinora::rib::ri::stream();
  stream.open(out);
  // functions that are not there matter when they are called
  void* const library = dlopen(object.c_str(), RTLD_LAZY | RTLD_GLOBAL);
  if (!library) return fail(dlerror());
  const auto convert = functionOf<RtPointer (*)(char*)>(library, "ConvertParameters");
  const auto subdivide = functionOf<RtVoid (*)(RtPointer, RtFloat)>(library, "Subdivide");
  const auto release = functionOf<RtVoid (*)(RtPointer)>(library, "Free");
  if (!convert || !subdivide)
    return fail("'" + object + "' has no function " + (convert ? "Subdivide" : "ConvertParameters") +
                " with C linkage");
  std::optional<std::span<const float, 6>> box;
  if (bound.size() == 6) box.emplace(bound.data(), 6);
  kinora::Hasher said;
  said.text(data);
  stream.begin(std::filesystem::path(object).filename().string() + " " + said.result().str() + " ", detail, box);
  const RtPointer own = convert(data.data());
  subdivide(own, RtFloat(detail));
  if (release) release(own);
  return stream.close() ? 0 : fail("what it prints cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Runs a shared object of Procedural \"DynamicLoad\" and prints its RIB.");
  std::string object, data;
  double detail = 1e6;
  std::vector<float> bound;
  app.add_option("object", object, "the shared object")->required();
  const CLI::Option* given = app.add_option("data", data, "the data of the request; else all of standard input");
  app.add_option("--detail", detail, "size of the bound on the screen, an area in pixels");
  app.add_option("--bound", bound, "of the request: the share of detail that procedurals in it have")->expected(6);
  CLI11_PARSE(app, argc, argv);
  if (given->empty()) data.assign(std::istreambuf_iterator<char>(std::cin), {});
  const int code = run(object, std::move(data), detail, bound);
  // not through what the object does at exit
  std::fflush(nullptr);
  _exit(code);
}
