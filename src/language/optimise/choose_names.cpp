// Names of noises and bases of splines that are known only at run time: the machine has a kernel for each, so the call
// becomes a choice among calls, each for the points that ask for it.
#include <string_view>
#include <vector>

#include "language/library/noise_name.h"
#include "language/optimise/optimise.h"

namespace kinora::language {

namespace {

// Names that mean the same, the first one standing for all.
using Names = std::vector<std::string_view>;

const std::vector<Names>& splineNames() {
  static const std::vector<Names> kAll = {{"catmull-rom"}, {"bezier"}, {"bspline"}, {"hermite"}, {"constant"}};
  return kAll;
}

std::vector<Names> noiseNames(bool isPeriodic) {
  static constexpr std::string_view kSpelled[] = {
      "perlin",        "snoise", "psnoise",   "uperlin", "noise",     "pnoise", "simplex", "simplexnoise", "usimplex",
      "usimplexnoise", "cell",   "cellnoise", "hash",    "hashnoise", "gabor",  "null",    "unull"};
  std::vector<Names> all;
  std::vector<NoiseKind> kinds;
  for (const std::string_view name : kSpelled) {
    const NoiseKind kind = noiseKind(name, isPeriodic, false);
    if (kind == NoiseKind::Unknown) continue;
    size_t at = 0;
    while (at < kinds.size() && kinds[at] != kind) ++at;
    if (at == kinds.size()) {
      kinds.push_back(kind);
      all.emplace_back();
    }
    all[at].push_back(name);
  }
  return all;
}

class Chooser {
 public:
  explicit Chooser(FlatProgram& flat) : shader_(flat.code), pool_(flat.code) {}

  void block(Block& code) {
    std::vector<Instruction> made;
    made.reserve(code.code.size());
    for (Instruction& in : code.code) {
      for (Block& inner : in.blocks) block(inner);
      if (isOpen(in))
        choose(in, made);
      else
        made.push_back(std::move(in));
    }
    code.code = std::move(made);
  }

 private:
  bool isOpen(const Instruction& in) const {
    const bool isNoise = in.opcode == Opcode::Noise || in.opcode == Opcode::PNoise;
    if (!isNoise && in.opcode != Opcode::Spline && in.opcode != Opcode::SplineInverse) return false;
    if (in.arguments.size() < 3) return false;
    const Symbol& name = shader_.symbols[size_t(in.arguments[1])];
    return name.type == Type{Base::String, 0, -1} && name.kind != SymbolKind::Constant;
  }

  void choose(const Instruction& in, std::vector<Instruction>& out) {
    const bool isNoise = in.opcode == Opcode::Noise || in.opcode == Opcode::PNoise;
    const bool isPeriodic = in.opcode == Opcode::PNoise;
    // from the last choice to the first, each within the other side of the one before
    Block rest;
    if (isNoise) {
      const std::string place = in.pos.file ? *in.pos.file : std::string();
      std::string text = unknownNoise("%s", isPeriodic, "", 0);
      text.resize(text.find(", called"));
      rest.code.push_back(like(in, Opcode::Complain,
                               {pool_.ofString(text + ", called from (%s:%d)"), in.arguments[1],
                                pool_.ofString(place), pool_.ofInt(int32_t(in.pos.line))}));
      rest.code.push_back(like(in, Opcode::Assign, {in.arguments[0], pool_.ofFloat(0)}));
    } else {
      rest.code.push_back(called(in, "linear"));  // any other name, as the reference has it
    }
    const std::vector<Names> all = isNoise ? noiseNames(isPeriodic) : splineNames();
    for (size_t k = all.size(); k-- > 0;) {
      Block test;
      const SymbolId holds = isAmong(in, all[k], test.code);
      Instruction choice = like(in, Opcode::If, {holds});
      choice.blocks.resize(2);
      choice.blocks[0].code.push_back(called(in, all[k][0]));
      choice.blocks[1] = std::move(rest);
      test.code.push_back(std::move(choice));
      rest = std::move(test);
    }
    for (Instruction& i : rest.code) out.push_back(std::move(i));
  }

  SymbolId isAmong(const Instruction& in, const Names& names, std::vector<Instruction>& out) {
    SymbolId any = kNone;
    for (const std::string_view name : names) {
      const SymbolId one = temporary();
      out.push_back(like(in, Opcode::Eq, {one, in.arguments[1], pool_.ofString(std::string(name))}));
      if (any == kNone) {
        any = one;
        continue;
      }
      const SymbolId both = temporary();
      out.push_back(like(in, Opcode::Or, {both, any, one}));
      any = both;
    }
    return any;
  }

  Instruction called(const Instruction& in, std::string_view name) {
    // names without a kernel of their own are numbers
    if (name == "null" || name == "unull")
      return like(in, Opcode::Assign, {in.arguments[0], pool_.ofFloat(name == "null" ? 0.f : 0.5f)});
    Instruction call = in;
    call.arguments[1] = pool_.ofString(std::string(name));
    return call;
  }

  Instruction like(const Instruction& in, Opcode op, std::vector<SymbolId> arguments) const {
    Instruction made;
    made.opcode = op;
    made.arguments = std::move(arguments);
    made.pos = in.pos;
    made.layer = in.layer;
    return made;
  }

  SymbolId temporary() {
    Symbol symbol;
    symbol.name = "$choice" + std::to_string(shader_.symbols.size());
    symbol.kind = SymbolKind::Temp;
    symbol.type = {Base::Int, 0, -1};
    shader_.symbols.push_back(std::move(symbol));
    return SymbolId(shader_.symbols.size()) - 1;
  }

  Shader& shader_;
  ConstantPool pool_;
};

}  // namespace

void chooseNames(FlatProgram& flat) { Chooser(flat).block(flat.code.main); }

}  // namespace kinora::language
