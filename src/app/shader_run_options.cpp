// The command line of `kinora shader run`, whose options are those of the tool that people's shader tests are written
// for. Options of that tool which only choose how it compiles or measures are read and mean nothing here.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "app/command_line.h"
#include "app/exit_codes.h"
#include "app/shader_run.h"

namespace kinora::app {

namespace {

constexpr const char* kRunHelp =
    R"(kinora shader run [options] SHADER [LAYER ...]: runs a shader or a network over a grid of points

Each SHADER (.osl, .oso) is one more layer; the last one is run and calls for the others.

  -g W H, --res W H      points across and down (1 1); u and v go from 0 to 1
  --center               u, v in the middle of pixels, not at the corners
  --scaleuv U V, --offsetuv U V   u = U u + offset ...; also --scalest, --offsetst
  --vary_pdxdy, --vary_udxdy, --vary_vdxdy   derivatives of P, u, v that differ from point to point
  --param[:type=T][:lockgeom=0|1] NAME VALUE   for the shader that follows; 1, 0.5, 1,2,3 or text
  --layer NAME           name of the layer that follows;  --shader SHADER LAYER: both
  --expr CODE            a shader of this code, with output color result, output float alpha
  --connect LAYER OUTPUT LAYER INPUT    also of components: Cout[0]
  --group TEXT, --groupname NAME        layers as text: "param float a 1; shader s l; connect l.b m.c;", or a file
  --entry LAYER          run this layer in place of the last one; may be repeated. --entryoutput LAYER.OUTPUT
  --reparam[:type=T] LAYER NAME VALUE   between iterations;  --iters N: how often all points are run (1)
  --userdata[:type=T] NAME VALUE        a primvar of all points
  --raytype NAME         the kind of ray (camera)
  -o OUTPUT FILE         an output as a picture; FILE null: only computed. -od uint8|half|float
  --print                the outputs as numbers, in place of pictures
  --options NAME=VALUE,...   error_repeats, range_checking, lazylayers, searchpath:shader ...
  --path DIR:DIR         where shaders are looked for;  -I DIR, -D NAME[=VALUE]: for .osl files
  --debugnan, --debuguninit   tell where a value becomes NaN or infinite; where one is used before it is set
  --colorspace NAME      the working colour space (Rec709)
  -t N                   threads (0: all);  --width N: 1, 4, 8 or 16. Neither changes a bit
  -O0 -O1 -O2            0: as written; else optimised
  -q                     print what the shaders print and nothing else;  -v: more;  --stats: times and sizes
)";

// Of the tool whose options these are, with the number of values that follow: accepted, without effect.
constexpr std::pair<const char*, int> kIgnored[] = {
    {"batched", 0},    {"debug", 0},          {"debug2", 0},          {"llvm_debug", 0},
    {"llvm_opt", 1},   {"profile", 0},        {"optix", 0},           {"saveptx", 0},
    {"warmup", 0},     {"groupoutputs", 0},   {"inbuffer", 0},        {"no-output-placement", 0},
    {"shadeimage", 0}, {"noshadeimage", 0},   {"raytype_opt", 0},     {"texoptions", 1},
    {"jbufferMB", 1},  {"use_rs_bitcode", 0}, {"print-groupdata", 0}, {"print-group-stats", 0},
    {"locale", 1}};

bool toInt(const std::string& text, int& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size();
}
bool toFloat(const std::string& text, float& out) {
  const char* first = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size() && out - out == 0;
}

}  // namespace

int RunJob::option(const char* name, int otherwise) const {
  const auto found = options.find(name);
  int value = otherwise;
  return found != options.end() && toInt(found->second, value) ? value : otherwise;
}

std::optional<int> parseRun(const Arguments& arguments, RunJob& job) {
  Diagnostics diagnostics;
  ShaderOptions o(arguments);
  std::string wrong;  // what the last value should have been
  const auto words = [&](size_t count) {
    std::vector<std::string> list(count);
    for (std::string& w : list)
      if (!o.value(w)) break;
    return list;
  };
  const auto whole = [&](int& out, int least, int most) {
    std::string text;
    int value = 0;
    if (!o.value(text)) return;
    if (!toInt(text, value) || value < least || value > most)
      wrong = fmt::format("'-{} {}': the value is a whole number from {} to {}", o.word(), text, least, most);
    else
      out = value;
  };
  const auto pair = [&](float(&out)[2]) {
    const std::vector<std::string> list = words(2);
    for (int i = 0; i < 2 && !o.isMissing(); ++i)
      if (!toFloat(list[size_t(i)], out[i])) wrong = fmt::format("'-{}' takes two numbers", o.word());
  };
  const auto step = [&](GroupStep::Kind kind, size_t count, std::string modifiers = {}) {
    job.steps.push_back({kind, std::move(modifiers), words(count)});
  };
  std::string value;
  while (wrong.empty() && o.next()) {
    const size_t colon = o.word().find(':');
    const std::string name = o.word().substr(0, colon);
    const std::string modifiers = colon == std::string::npos ? "" : o.word().substr(colon + 1);
    const auto ignored =
        std::find_if(std::begin(kIgnored), std::end(kIgnored), [&](const auto& entry) { return o.is(entry.first); });
    if (!o.isOption()) {
      job.steps.push_back({GroupStep::Shader, {}, {o.word()}});
    } else if (o.is("help") || o.is("h")) {
      fmt::print("{}", kRunHelp);
      return kComplete;
    } else if (o.is("g") || o.is("res")) {
      int size[2] = {1, 1};
      for (int i = 0; i < 2 && wrong.empty() && !o.isMissing(); ++i) whole(size[i], 1, 1 << 20);
      job.grid.width = uint32_t(size[0]);
      job.grid.height = uint32_t(size[1]);
      if (wrong.empty() && job.grid.points() > (uint64_t(1) << 28))
        wrong = fmt::format("a grid of {} x {} points is too large: at most {}", size[0], size[1], 1 << 28);
    } else if (o.is("center")) {
      job.grid.isCentered = true;
    } else if (o.is("vary_pdxdy")) {
      job.grid.varyP = true;
    } else if (o.is("vary_udxdy")) {
      job.grid.varyU = true;
    } else if (o.is("vary_vdxdy")) {
      job.grid.varyV = true;
    } else if (o.is("scaleuv") || o.is("scalest")) {
      pair(job.grid.scale);
    } else if (o.is("offsetuv") || o.is("offsetst")) {
      pair(job.grid.offset);
    } else if (name == "param") {
      step(GroupStep::Param, 2, modifiers);
    } else if (name == "reparam") {
      step(GroupStep::Reparam, 3, modifiers);
    } else if (name == "userdata") {
      step(GroupStep::UserData, 2, modifiers);
    } else if (o.is("layer")) {
      step(GroupStep::LayerName, 1);
    } else if (o.is("shader")) {
      std::vector<std::string> list = words(2);
      if (!o.isMissing()) {
        job.steps.push_back({GroupStep::LayerName, {}, {list[1]}});
        job.steps.push_back({GroupStep::Shader, {}, {list[0]}});
      }
    } else if (o.is("connect")) {
      step(GroupStep::Connect, 4);
    } else if (o.is("group")) {
      step(GroupStep::Group, 1);
    } else if (o.is("expr")) {
      step(GroupStep::Expression, 1);
    } else if (o.is("groupname")) {
      o.value(job.groupName);
    } else if (o.is("entry")) {
      if (o.value(value)) job.entries.push_back(value);
    } else if (o.is("entryoutput")) {
      o.value(job.entryOutput);
    } else if (o.is("iters")) {
      whole(job.iterations, 1, 1 << 30);
    } else if (o.is("raytype")) {
      o.value(job.rayType);
    } else if (o.is("o")) {
      const std::vector<std::string> list = words(2);
      if (!o.isMissing()) job.outputs.push_back({list[0], list[1]});
    } else if (o.is("od") || o.is("d")) {
      o.value(job.storedType);
      if (!o.isMissing() && job.storedType != "uint8" && job.storedType != "half" && job.storedType != "float")
        wrong = fmt::format("'-{} {}': the type is uint8, half or float", o.word(), job.storedType);
    } else if (o.is("print")) {
      job.printsOutputs = true;
    } else if (o.is("options")) {
      if (o.value(value))
        for (size_t at = 0; at < value.size();) {
          const size_t end = std::min(value.find(',', at), value.size());
          const std::string one = value.substr(at, end - at);
          const size_t equal = one.find('=');
          if (equal != std::string::npos) job.options[one.substr(0, equal)] = one.substr(equal + 1);
          at = end + 1;
        }
    } else if (o.is("path")) {
      if (o.value(value)) job.options["searchpath:shader"] = value;
    } else if (o.is("debugnan")) {
      job.debugNan = true;
    } else if (o.is("debuguninit")) {
      job.debugUninit = true;
    } else if (o.is("userdata_isconnected")) {
      job.userDataIsConnected = true;
    } else if (o.is("colorspace")) {
      o.value(job.colorSpace);
    } else if (o.is("t")) {
      whole(job.threads, 0, 1024);
    } else if (o.is("width")) {
      whole(job.width, 0, 16);
      if (wrong.empty() && job.width != 0 && job.width != 1 && job.width != 4 && job.width != 8 && job.width != 16)
        wrong = "--width is 1, 4, 8 or 16";
    } else if (o.is("O0") || o.is("O1") || o.is("O2")) {
      job.optimisation = o.word()[1] - '0';
    } else if (o.is("q")) {
      job.isQuiet = true;
    } else if (o.is("v") || o.is("oslquery")) {
      job.isVerbose = true;
    } else if (o.is("stats") || o.is("runstats")) {
      job.hasStats = true;
    } else if (o.letter('I', value)) {
      job.compile.includePaths.push_back(value);
    } else if (o.letter('D', value)) {
      job.compile.defines.push_back(value);
    } else if (o.letter('U', value)) {
      job.compile.undefines.push_back(value);
    } else if (ignored != std::end(kIgnored)) {
      words(size_t(ignored->second));
    } else if (!o.isMissing()) {
      return badCommandLine(diagnostics, "unknown option '-" + o.word() + "'", "see `kinora shader run --help`");
    }
    if (o.isMissing()) return badCommandLine(diagnostics, "option -" + o.word() + " needs more values");
  }
  if (!wrong.empty()) return badCommandLine(diagnostics, wrong);
  const bool hasShader = std::any_of(job.steps.begin(), job.steps.end(), [](const GroupStep& s) {
    return s.kind == GroupStep::Shader || s.kind == GroupStep::Group || s.kind == GroupStep::Expression;
  });
  if (!hasShader) return badCommandLine(diagnostics, "no shader or group is given", "see `kinora shader run --help`");
  for (const auto& [key, text] : job.options)
    if (key == "searchpath:shader")
      for (size_t at = 0; at <= text.size();) {
        const size_t end = std::min(text.find_first_of(":;", at), text.size());
        if (end > at) job.path.push_back(text.substr(at, end - at));
        at = end + 1;
      }
  return std::nullopt;
}

}  // namespace kinora::app
