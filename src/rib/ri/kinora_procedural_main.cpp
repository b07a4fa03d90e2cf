// kinora-procedural OBJECT [DATA]: runs a shared object of Procedural "DynamicLoad", or with --list of Procedural2, and
// prints the RIB of what it calls (include/kinora/ri.h). Kinora starts it where scenes may run programs (--allow-exec):
// what an object does to this process it does to no picture. By hand it makes an archive of a procedural.
#include <dlfcn.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <string_view>
#include <vector>

#include "base/digest.h"
#include "rib/byte_source.h"
#include "rib/declarations.h"
#include "rib/lexer.h"
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

// The list of a Procedural2, as the functions of an object take one. Values are arrays of what their tokens declare.
class ParameterArrays {
 public:
  explicit ParameterArrays(const std::string& text) {
    constexpr std::string_view kRequest = "Procedural2";
    kinora::rib::Lexer lexer(kinora::rib::openText(std::string(kRequest) + " " + text), "parameters", errors_,
                             [](std::string_view word) { return word == kRequest; });
    lexer.readRequest(request_);
    kinora::rib::Declarations declarations;
    texts_.reserve(request_.count);
    for (size_t i = 0; i + 1 < request_.count; i += 2) {
      kinora::rib::Argument &token = request_.args[i], &value = request_.args[i + 1];
      const kinora::rib::Declaration* d = token.isString() ? declarations.find(token.strings[0]) : nullptr;
      if (!d || value.size() == 0) {
        std::cerr << "kinora-procedural: argument " << i + 1 << " is no parameter; it is left out" << std::endl;
        continue;
      }
      if (d->name == "data" && !value.strings.empty()) data_ = value.strings[0];
      tokens_.push_back(token.strings[0].data());
      values_.push_back(arrayOf(value, *d));
    }
  }
  RtInt count() const { return RtInt(tokens_.size()); }
  RtToken* tokens() { return tokens_.data(); }
  RtPointer* values() { return values_.data(); }
  const std::string& data() const { return data_; }  // of "string data"

 private:
  RtPointer arrayOf(kinora::rib::Argument& value, const kinora::rib::Declaration& declared) {
    if (value.kind == kinora::rib::Argument::Kind::Strings) {
      std::vector<RtString>& texts = texts_.emplace_back();
      for (std::string& s : value.strings) texts.push_back(s.data());
      return texts.data();
    }
    if (value.isInteger && declared.type == kinora::scene::ValueType::Int) return value.ints.data();
    if (value.isInteger) value.becomeFloats();
    return value.floats.data();
  }

  kinora::Diagnostics errors_;    // on standard error
  kinora::rib::Request request_;  // what the pointers lead to
  std::vector<std::vector<RtString>> texts_;
  std::vector<RtToken> tokens_;
  std::vector<RtPointer> values_;
  std::string data_;
};

int run(const std::string& object, std::string data, bool isList, double detail, const std::vector<float>& bound) {
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
  using WithList = RtVoid (*)(RtContextHandle, RtFloat, RtInt, RtToken[], RtPointer[]);
  const auto subdivideList = isList ? functionOf<WithList>(library, "Subdivide2") : nullptr;
  if (!subdivideList && (!convert || !subdivide))
    return fail("'" + object + "' has no function " + (isList ? "Subdivide2, and none " : "") +
                (convert ? "Subdivide" : "ConvertParameters") + " with C linkage");
  std::optional<std::span<const float, 6>> box;
  if (bound.size() == 6) box.emplace(bound.data(), 6);
  kinora::Hasher said;
  said.text(data);
  stream.begin(std::filesystem::path(object).filename().string() + " " + said.result().str() + " ", detail, box);
  if (isList) {
    ParameterArrays list(data);
    if (subdivideList) {
      subdivideList(RiGetContext(), RtFloat(detail), list.count(), list.tokens(), list.values());
      return stream.close() ? 0 : fail("what it prints cannot be written");
    }
    data = list.data();
  }
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
  bool isList = false;
  std::vector<float> bound;
  app.add_option("object", object, "the shared object")->required();
  const CLI::Option* given = app.add_option("data", data, "the data of the request; else all of standard input");
  app.add_option("--detail", detail, "size of the bound on the screen, an area in pixels");
  app.add_option("--bound", bound, "of the request: the share of detail that procedurals in it have")->expected(6);
  app.add_flag("--list", isList, "the data are a parameter list of Procedural2, as RIB: '\"int seed\" [7]'");
  CLI11_PARSE(app, argc, argv);
  if (given->empty()) data.assign(std::istreambuf_iterator<char>(std::cin), {});
  const int code = run(object, std::move(data), isList, detail, bound);
  // not through what the object does at exit
  std::fflush(nullptr);
  _exit(code);
}
