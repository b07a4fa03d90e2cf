#include "language/optimise/analysis.h"

#include "language/optimise/liveness.h"
#include "language/optimise/walk.h"

namespace kinora::language {

bool isFloatBased(Base b) { return b == Base::Float || isTriple(b); }
bool carriesDerivsIn(std::string_view g) { return g == "P" || g == "I" || g == "u" || g == "v" || g == "Ps"; }

namespace {

class Analyser {
 public:
  explicit Analyser(const FlatProgram& flat) : flat_(flat), shader_(flat.code) {}

  Analysis run() {
    const size_t n = shader_.symbols.size();
    a_.home.assign(n, -1);
    a_.isVarying.assign(n, 0);
    a_.hasDerivs.assign(n, 0);
    a_.needsZero.assign(n, 0);
    a_.regions.push_back({Region::Root, -1, false});
    depth_.push_back(0);
    findRegions(shader_.main, 0);
    for (const Output& o : flat_.outputs) touch(o.symbol, 0);
    findHomes();
    findVarying();
    findDerivs();
    return std::move(a_);
  }

 private:
  int32_t addRegion(Region::Kind kind, int32_t parent, const void* key) {
    a_.regions.push_back({kind, parent, false});
    depth_.push_back(depth_[size_t(parent)] + 1);
    const int32_t id = int32_t(a_.regions.size()) - 1;
    a_.regionOf.emplace(key, id);
    return id;
  }
  int32_t common(int32_t a, int32_t b) const {
    while (a != b) {
      if (depth_[size_t(a)] >= depth_[size_t(b)])
        a = a_.regions[size_t(a)].parent;
      else
        b = a_.regions[size_t(b)].parent;
    }
    return a;
  }
  void touch(SymbolId s, int32_t region) {
    int32_t& home = a_.home[size_t(s)];
    home = home < 0 ? region : common(home, region);
  }

  void findRegions(const Block& block, int32_t region) {
    for (const Instruction& in : block.code) {
      const bool loop = isLoop(in.opcode);
      int32_t own = region;
      if (loop) own = addRegion(Region::Loop, region, &in);
      for (const SymbolId s : in.arguments) touch(s, own);
      if (in.opcode == Opcode::If)
        for (const Block& b : in.blocks) findRegions(b, addRegion(Region::Branch, region, &b));
      if (in.opcode == Opcode::Call)
        findRegions(in.blocks[0],
                    addRegion(in.arguments.size() == 2 ? Region::Layer : Region::Call, region, &in.blocks[0]));
      if (loop) {
        findRegions(in.blocks[0], region);
        findRegions(in.blocks[1], own);
        findRegions(in.blocks[2], addRegion(Region::Body, own, &in.blocks[2]));
        findRegions(in.blocks[3], own);
      }
    }
  }

  void findHomes() {
    const size_t n = shader_.symbols.size();
    std::vector<SymbolSet> entry(a_.regions.size(), SymbolSet(n));
    Liveness liveness(shader_);
    liveness.atEntry = [&](const void* key, const SymbolSet& live) { entry[size_t(a_.regionOf.at(key))] = live; };
    SymbolSet live(n);
    for (const Output& o : flat_.outputs) live.add(o.symbol);
    liveness.run(shader_.main, live);
    entry[0] = live;
    for (size_t s = 0; s < n; ++s) {
      int32_t& home = a_.home[s];
      if (home < 0) continue;
      while (home > 0 && entry[size_t(home)].has(SymbolId(s))) home = a_.regions[size_t(home)].parent;
      const SymbolKind kind = shader_.symbols[s].kind;
      if (kind == SymbolKind::Local || kind == SymbolKind::Temp)
        a_.needsZero[s] = entry[0].has(SymbolId(s));
      else
        home = 0;
    }
  }

  // Whether a mask changes between `region` and `target`, which is an ancestor or the same.
  bool divergesBelow(int32_t region, int32_t target) const {
    for (int32_t r = region; r != target; r = a_.regions[size_t(r)].parent)
      if (a_.regions[size_t(r)].isDivergent) return true;
    return false;
  }
  void diverge(int32_t region) {
    if (!a_.regions[size_t(region)].isDivergent) a_.regions[size_t(region)].isDivergent = changed_ = true;
  }
  void vary(SymbolId s) {
    if (!a_.isVarying[size_t(s)]) a_.isVarying[size_t(s)] = changed_ = true;
  }
  // Points leave everything up to `target` one by one.
  void leave(int32_t region, int32_t target) {
    if (!divergesBelow(region, target)) return;
    diverge(target);
    for (int32_t r = region; r != target; r = a_.regions[size_t(r)].parent)
      if (a_.regions[size_t(r)].kind == Region::Loop || a_.regions[size_t(r)].kind == Region::Call) diverge(r);
  }
  int32_t enclosing(int32_t region, Region::Kind kind, Region::Kind orKind) const {
    while (region > 0 && a_.regions[size_t(region)].kind != kind && a_.regions[size_t(region)].kind != orKind)
      region = a_.regions[size_t(region)].parent;
    return region;
  }

  void spread(const Block& block, int32_t region) {
    for (const Instruction& in : block.code) {
      switch (in.opcode) {
        case Opcode::If:
          for (const Block& b : in.blocks) {
            const int32_t inner = a_.regionOf.at(&b);
            if (a_.isVarying[size_t(in.arguments[0])]) diverge(inner);
            spread(b, inner);
          }
          continue;
        case Opcode::Call:
          spread(in.blocks[0], a_.regionOf.at(&in.blocks[0]));
          continue;
        case Opcode::For:
        case Opcode::While:
        case Opcode::DoWhile: {
          const int32_t loop = a_.regionOf.at(&in);
          if (a_.isVarying[size_t(in.arguments[0])]) diverge(loop);
          spread(in.blocks[0], region);
          spread(in.blocks[1], loop);
          spread(in.blocks[2], a_.regionOf.at(&in.blocks[2]));
          spread(in.blocks[3], loop);
          continue;
        }
        case Opcode::Break:
          leave(region, enclosing(region, Region::Loop, Region::Loop));
          continue;
        case Opcode::Continue:
          leave(region, enclosing(region, Region::Body, Region::Body));
          continue;
        case Opcode::Return:
          leave(region, enclosing(region, Region::Call, Region::Layer));
          continue;
        case Opcode::Exit:
          leave(region, enclosing(region, Region::Layer, Region::Layer));
          continue;
        default:
          break;
      }
      bool varies = factsOf(in.opcode).flags & kOpGlobalState;
      for (uint32_t i = 0; i < in.arguments.size() && !varies; ++i)
        if (accessOf(shader_, in, i) != 'w') varies = a_.isVarying[size_t(in.arguments[i])];
      if (in.opcode == Opcode::Trace || in.opcode == Opcode::GetMessage) varies = true;
      for (uint32_t i = 0; i < in.arguments.size(); ++i) {
        const SymbolId s = in.arguments[i];
        if (accessOf(shader_, in, i) != 'r' && (varies || a_.blends(region, s))) vary(s);
      }
    }
  }

  void findVarying() {
    for (size_t s = 0; s < shader_.symbols.size(); ++s)
      if (shader_.symbols[s].kind == SymbolKind::Global) a_.isVarying[s] = 1;
    for (const Input& input : flat_.inputs)
      if (input.isVarying) a_.isVarying[size_t(input.symbol)] = 1;
    do {
      changed_ = false;
      spread(shader_.main, 0);
    } while (changed_);
  }

  static bool takesDerivs(const Shader& shader, const Instruction& in) {
    if (!(factsOf(in.opcode).flags & kOpTakesDerivs)) return false;
    if (in.opcode != Opcode::Noise && in.opcode != Opcode::PNoise) return true;
    const Symbol& name = shader.symbols[size_t(in.arguments[1])];
    return !(name.kind == SymbolKind::Constant && name.type.base == Base::String && !name.values.strings.empty() &&
             name.values.strings[0] != "gabor") &&
           name.type.base == Base::String;
  }

  void findDerivs() {
    const size_t n = shader_.symbols.size();
    std::vector<uint8_t> needs(n, 0), has(n, 0);
    for (size_t s = 0; s < n; ++s)
      if (shader_.symbols[s].kind == SymbolKind::Global && carriesDerivsIn(shader_.symbols[s].name)) has[s] = 1;
    for (const Input& input : flat_.inputs) has[size_t(input.symbol)] = input.hasDerivs;
    const auto floats = [&](SymbolId s) { return isFloatBased(shader_.symbols[size_t(s)].type.base); };
    for (changed_ = true; changed_;) {
      changed_ = false;
      forEachInstruction(shader_.main, [&](const Instruction& in) {
        const uint32_t flags = factsOf(in.opcode).flags;
        if (flags & kOpBlocks) return;
        bool wanted = takesDerivs(shader_, in), source = false;
        for (uint32_t i = 0; i < in.arguments.size(); ++i) {
          const char access = accessOf(shader_, in, i);
          if (access != 'r' && !(flags & kOpDropsDerivs) && needs[size_t(in.arguments[i])]) wanted = true;
          if (access != 'w' && floats(in.arguments[i]) && has[size_t(in.arguments[i])]) source = true;
        }
        if (flags & kOpDropsDerivs) source = false;
        for (uint32_t i = 0; i < in.arguments.size(); ++i) {
          const SymbolId s = in.arguments[i];
          if (!floats(s)) continue;
          const char access = accessOf(shader_, in, i);
          if (wanted && access != 'w' && !needs[size_t(s)]) needs[size_t(s)] = changed_ = true;
          if (source && access != 'r' && !has[size_t(s)]) has[size_t(s)] = changed_ = true;
        }
      });
    }
    for (size_t s = 0; s < n; ++s) a_.hasDerivs[s] = needs[s] && has[s] && a_.isVarying[s];
  }

  const FlatProgram& flat_;
  const Shader& shader_;
  Analysis a_;
  std::vector<int32_t> depth_;
  bool changed_ = false;
};

}  // namespace

Analysis analyse(const FlatProgram& flat) { return Analyser(flat).run(); }

}  // namespace kinora::language
