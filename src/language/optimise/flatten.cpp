#include <algorithm>
#include <unordered_map>

#include "language/optimise/group.h"
#include "language/optimise/instruction.h"
#include "language/optimise/optimise.h"
#include "language/optimise/settings.h"
#include "language/optimise/walk.h"

namespace kinora::language {

namespace {

constexpr size_t kMostLayers = 4096;

struct Link {  // one connection of values that are no structs
  int32_t fromLayer, toLayer;
  SymbolId from, to;
  int32_t fromComponent = -1, toComponent = -1;
};

class Flattener {
 public:
  Flattener(const ShaderGroup& group, FlatProgram& flat) : group_(group), flat_(flat), pool_(flat.code) {}

  bool run(std::string& error) {
    flat_.group = group_.name.empty() ? "unnamed_group" : group_.name;
    flat_.code.name = flat_.group;
    if (group_.layers.empty()) errors_ += "the shader group has no layer\n";
    if (group_.layers.size() > kMostLayers)
      errors_ += "the shader group has more than " + std::to_string(kMostLayers) + " layers\n";
    if (errors_.empty()) {
      for (const Layer& layer : group_.layers) {
        flat_.layers.push_back(layer.name);
        flat_.shaders.push_back(layer.shader->name);
        flat_.mostTurns.push_back(0);
        for (const Metadata& m : layer.shader->metadata)
          if (m.name == "kinora_max_iterations" && m.values.ints.size() == 1)
            flat_.mostTurns.back() = uint32_t(std::clamp(m.values.ints[0], 1, 1 << 30));
        facts_.push_back(factsOfShader(*layer.shader));
      }
      checkSettings();
      for (const Connection& c : group_.connections) connect(c);
      findOutputs();
      for (const std::string& entry : group_.entries)
        if (layerNamed(entry) < 0) errors_ += "no layer is named `" + entry + "`, which should be run\n";
      if (errors_.empty()) order();
      if (errors_.empty()) build();
    }
    error = errors_;
    if (!error.empty() && error.back() == '\n') error.pop_back();
    return error.empty();
  }

 private:
  int32_t layerNamed(const std::string& name) const {
    for (size_t i = 0; i < group_.layers.size(); ++i)
      if (group_.layers[i].name == name) return int32_t(i);
    return -1;
  }
  SymbolId paramNamed(int32_t layer, const std::string& name) const {
    const Shader& shader = *group_.layers[size_t(layer)].shader;
    const SymbolId id = shader.find(name);
    return id != kNone && isParam(shader.symbols[size_t(id)]) ? id : kNone;
  }

  void checkSettings() {
    for (size_t l = 0; l < group_.layers.size(); ++l) {
      const Layer& layer = group_.layers[l];
      for (const Setting& setting : layer.settings) {
        const SymbolId id = paramNamed(int32_t(l), setting.parameter);
        if (id == kNone) {
          flat_.warnings.push_back("shader " + layer.shader->name + " has no parameter `" + setting.parameter + "`");
          continue;
        }
        Type type = layer.shader->symbols[size_t(id)].type;
        if (type.arrayLength < 0) type.arrayLength = int32_t(elementsIn(setting.type, setting.values));
        Values converted;
        if (type.arrayLength > kMostElements || !convertSetting(setting.type, setting.values, type, converted))
          errors_ += "parameter `" + setting.parameter + "` of shader " + layer.shader->name + " is a " +
                     nameOf(layer.shader->symbols[size_t(id)].type) + " and was given a " + nameOf(setting.type) +
                     "\n";
      }
    }
  }

  // "name" or "name[component]".
  bool endpoint(const std::string& layerName, const std::string& text, int32_t& layer, SymbolId& symbol,
                int32_t& component) {
    layer = layerNamed(layerName);
    if (layer < 0) {
      errors_ += "ConnectShaders: no layer is named `" + layerName + "`\n        group: " + flat_.group + "\n";
      return false;
    }
    std::string name = text;
    component = -1;
    const size_t open = name.find('[');
    if (open != std::string::npos && name.back() == ']') {
      component = std::atoi(name.c_str() + open + 1);
      name.resize(open);
    }
    symbol = paramNamed(layer, name);
    if (symbol == kNone) {
      errors_ += "ConnectShaders: `" + name + "` is no parameter of shader " +
                 group_.layers[size_t(layer)].shader->name + " (layer " + layerName +
                 ")\n        group: " + flat_.group + "\n";
      return false;
    }
    const Type& type = group_.layers[size_t(layer)].shader->symbols[size_t(symbol)].type;
    const int32_t parts = type.arrayLength > 0                                  ? type.arrayLength
                          : type.arrayLength < 0 || componentsOf(type.base) < 3 ? 0
                                                                                : componentsOf(type.base);
    if (component >= parts) {
      errors_ +=
          "ConnectShaders: `" + text + "` is no part of a " + nameOf(type) + "\n        group: " + flat_.group + "\n";
      return false;
    }
    return true;
  }

  std::string spelled(int32_t layer, SymbolId symbol) const {
    const Shader& shader = *group_.layers[size_t(layer)].shader;
    const Symbol& s = shader.symbols[size_t(symbol)];
    const std::string type = s.type.base == Base::Struct && s.type.structure >= 0
                                 ? "struct " + shader.structures[size_t(s.type.structure)].name
                                 : nameOf(s.type);
    return type + " (" + s.name + ")";
  }

  static bool isAssignable(const Type& to, const Type& from) {
    if (to.arrayLength != 0 || from.arrayLength != 0) {
      if (to.arrayLength == 0 || from.arrayLength == 0) return false;
      if (to.arrayLength > 0 && from.arrayLength > 0 && to.arrayLength != from.arrayLength) return false;
      return to.base == from.base || (isTriple(to.base) && isTriple(from.base));
    }
    if (to.base == from.base) return true;
    if (isTriple(to.base)) return isTriple(from.base) || from.base == Base::Float || from.base == Base::Int;
    if (to.base == Base::Float) return from.base == Base::Int;
    if (to.base == Base::Matrix) return from.base == Base::Float || from.base == Base::Int;
    return false;
  }

  // Of an element of an array, else of a component.
  static Type partType(const Type& type) { return {type.arrayLength ? type.base : Base::Float, 0, -1}; }

  void connect(const Connection& c) {
    Link link;
    if (!endpoint(c.fromLayer, c.from, link.fromLayer, link.from, link.fromComponent) ||
        !endpoint(c.toLayer, c.to, link.toLayer, link.to, link.toComponent))
      return;
    const Shader& a = *group_.layers[size_t(link.fromLayer)].shader;
    const Shader& b = *group_.layers[size_t(link.toLayer)].shader;
    Type from = a.symbols[size_t(link.from)].type, to = b.symbols[size_t(link.to)].type;
    const auto refuse = [&](const char* why = "") {
      errors_ += "ConnectShaders: cannot connect a " + spelled(link.fromLayer, link.from) + " to a " +
                 spelled(link.toLayer, link.to) + why + "\n        group: " + flat_.group + "\n";
    };
    for (const Metadata& meta : b.symbols[size_t(link.to)].metadata)
      if (meta.name == "allowconnect" && !meta.values.ints.empty() && meta.values.ints[0] == 0)
        return refuse(": its metadata has allowconnect = 0");
    if (from.base == Base::Struct || to.base == Base::Struct) {
      if (from.base != to.base || from.arrayLength != to.arrayLength || !connectFields(link, a, b)) refuse();
      return;
    }
    if (link.fromComponent >= 0) from = partType(from);
    if (link.toComponent >= 0) to = partType(to);
    if (!isAssignable(to, from)) return refuse();
    links_.push_back(link);
  }

  static std::vector<SymbolId> fieldsOf(const Shader& shader, SymbolId whole) {
    std::vector<SymbolId> fields;
    for (size_t i = 0; i < shader.symbols.size(); ++i)
      if (shader.symbols[i].ofStruct == whole) fields.push_back(SymbolId(i));
    std::sort(fields.begin(), fields.end(), [&](SymbolId x, SymbolId y) {
      return shader.symbols[size_t(x)].field < shader.symbols[size_t(y)].field;
    });
    return fields;
  }
  bool connectFields(const Link& link, const Shader& a, const Shader& b) {
    const auto from = fieldsOf(a, link.from), to = fieldsOf(b, link.to);
    if (from.size() != to.size()) return false;
    for (size_t i = 0; i < from.size(); ++i) {
      Link field = link;
      field.from = from[i];
      field.to = to[i];
      const Type &x = a.symbols[size_t(from[i])].type, &y = b.symbols[size_t(to[i])].type;
      if (x.base == Base::Struct && y.base == Base::Struct) {
        if (!connectFields(field, a, b)) return false;
      } else if (!(x.base == y.base && x.arrayLength == y.arrayLength)) {
        return false;
      } else {
        links_.push_back(field);
      }
    }
    return true;
  }

  void findOutputs() {
    for (const std::string& name : group_.outputs) {
      int32_t layer = int32_t(group_.layers.size()) - 1;
      SymbolId symbol = paramNamed(layer, name);
      for (size_t dot = name.find('.'); symbol == kNone && dot != std::string::npos; dot = name.find('.', dot + 1)) {
        layer = layerNamed(name.substr(0, dot));
        if (layer >= 0) symbol = paramNamed(layer, name.substr(dot + 1));
      }
      if (symbol == kNone || group_.layers[size_t(layer)].shader->symbols[size_t(symbol)].type.base == Base::Struct)
        errors_ += "`" + name + "` is no output of the group\n";
      else
        outputs_.push_back({name, layer, symbol});
    }
  }

  // Sources before what they feed; the last layer stays last. A cycle is an error that names its layers.
  void order() {
    std::vector<uint8_t> state(group_.layers.size(), 0);
    std::vector<std::vector<int32_t>> sources(group_.layers.size());
    for (const Link& link : links_) sources[size_t(link.toLayer)].push_back(link.fromLayer);
    for (size_t root = 0; root < group_.layers.size() && errors_.empty(); ++root) {
      std::vector<std::pair<int32_t, size_t>> stack;
      if (!state[root]) stack.push_back({int32_t(root), 0}), state[root] = 1;
      while (!stack.empty()) {
        auto& [layer, next] = stack.back();
        if (next == sources[size_t(layer)].size()) {
          state[size_t(layer)] = 2;
          order_.push_back(layer);
          stack.pop_back();
          continue;
        }
        const int32_t source = sources[size_t(layer)][next++];
        if (state[size_t(source)] == 1) {
          errors_ += "the shader network is cyclic: ";
          size_t first = 0;
          while (stack[first].first != source) ++first;
          for (size_t i = first; i < stack.size(); ++i)
            errors_ += group_.layers[size_t(stack[i].first)].name + " <- ";
          errors_ += group_.layers[size_t(source)].name + "\n        group: " + flat_.group + "\n";
          return;
        }
        if (!state[size_t(source)]) {
          state[size_t(source)] = 1;
          stack.push_back({source, 0});
        }
      }
    }
  }

  SymbolId addSymbol(Symbol symbol, int32_t layer) {
    if (symbol.kind == SymbolKind::Param || symbol.kind == SymbolKind::OutputParam) symbol.kind = SymbolKind::Local;
    symbol.ofStruct = kNone;
    symbol.metadata.clear();
    flat_.code.symbols.push_back(std::move(symbol));
    provider_.resize(flat_.code.symbols.size(), -1);
    provider_.back() = layer;
    return SymbolId(flat_.code.symbols.size() - 1);
  }
  SymbolId globalNamed(const Symbol& symbol) {
    const auto found = globals_.find(symbol.name);
    if (found != globals_.end()) return found->second;
    return globals_[symbol.name] = addSymbol(symbol, -1);
  }

  // Elements that an array without a length is given; 0: none, its default is {}.
  int32_t elementsGiven(int32_t layer, SymbolId id) const {
    const Layer& l = group_.layers[size_t(layer)];
    const Symbol& s = l.shader->symbols[size_t(id)];
    for (const Link& link : links_)
      if (link.toLayer == layer && link.to == id) return std::max(1, resolved(link.fromLayer, link.from).arrayLength);
    const Setting* setting = settingOf(l, s.name);
    const size_t n = setting ? elementsIn(setting->type, setting->values) : elementsIn(s.type, s.values);
    return int32_t(std::min(n, size_t(kMostElements)));
  }
  // Where there are no elements, one of zero stands for what is never there.
  Type resolved(int32_t layer, SymbolId id) const {
    Type type = group_.layers[size_t(layer)].shader->symbols[size_t(id)].type;
    if (type.arrayLength < 0) type.arrayLength = std::max(1, elementsGiven(layer, id));
    return type;
  }
  bool hasNoElements(int32_t layer, SymbolId id) const {
    const Type& type = group_.layers[size_t(layer)].shader->symbols[size_t(id)].type;
    return type.arrayLength < 0 && componentsOf(type.base) && elementsGiven(layer, id) == 0;
  }

  // The layer's symbols and the code that sets its parameters up.
  void prepare(int32_t layer, Block& setup) {
    const Layer& l = group_.layers[size_t(layer)];
    const Shader& shader = *l.shader;
    const ShaderFacts& facts = facts_[size_t(layer)];
    std::vector<SymbolId>& map = maps_[size_t(layer)];
    map.assign(shader.symbols.size(), kNone);
    std::vector<uint8_t> wholly(shader.symbols.size()), partly(shader.symbols.size());
    for (const Link& link : links_)
      if (link.toLayer == layer) (link.toComponent < 0 ? wholly : partly)[size_t(link.to)] = 1;
    std::vector<std::pair<SymbolId, SymbolId>> literals;  // parameter, its first value
    std::unordered_map<SymbolId, std::pair<SymbolId, SymbolId>>
        partial;  // parameter: value of a point, whether it is there
    for (size_t i = 0; i < shader.symbols.size(); ++i) {
      const Symbol& s = shader.symbols[i];
      Symbol made = s;
      made.name = l.name + "." + s.name;
      switch (s.kind) {
        case SymbolKind::Constant:
          map[i] = pool_.find(s.type, s.values);
          provider_.resize(flat_.code.symbols.size(), -1);
          continue;
        case SymbolKind::Global:
          map[i] = globalNamed(s);
          if (facts.isWritten[i] && componentsOf(s.type.base)) {  // the layer's own, which begins as the point's
            const SymbolId given = map[i];
            made.kind = SymbolKind::Local;
            map[i] = addSymbol(std::move(made), layer);
            setup.code.push_back(makeInstruction(Opcode::Assign, {map[i], given}, layer));
          }
          continue;
        case SymbolKind::Local:
        case SymbolKind::Temp:
          if (made.type.arrayLength < 0) made.type.arrayLength = 1;
          map[i] = addSymbol(std::move(made), layer);
          continue;
        default:
          break;
      }
      made.type = resolved(layer, SymbolId(i));
      if (s.type.base == Base::Struct || wholly[i]) {
        map[i] = addSymbol(std::move(made), layer);
        continue;
      }
      const PerPoint perPoint = group_.perPoint ? group_.perPoint(l, s) : PerPoint();
      const Setting* setting = settingOf(l, s.name);
      if (perPoint.isVarying && perPoint.isPartial && s.hasInitCode && !setting && made.type.arrayLength == 0) {
        const auto input = [&](const Type& type, const std::string& name, bool hasDerivs) {
          Symbol in = made;
          in.type = type;
          in.name = l.name + "." + name;
          const SymbolId id = addSymbol(std::move(in), -1);
          flat_.code.symbols[size_t(id)].kind = SymbolKind::Param;
          flat_.code.symbols[size_t(id)].values = Values();
          flat_.inputs.push_back({layer, name, type, id, true, hasDerivs, Values()});
          return id;
        };
        partial[SymbolId(i)] = {input(made.type, s.name, perPoint.hasDerivs),
                                input({Base::Int, 0, -1}, s.name + "?", false)};
        map[i] = addSymbol(std::move(made), layer);
        continue;
      }
      const bool hasCode = s.hasInitCode && !setting && !perPoint.isVarying;
      SymbolId value = kNone;
      if (!hasCode && componentsOf(s.type.base)) {
        Values values;
        if (setting)
          convertSetting(setting->type, setting->values, made.type, values);
        else
          values = s.values;
        if (made.type.base == Base::String)
          values.strings.resize(countOf(made.type));
        else if (made.type.base == Base::Int)
          values.ints.resize(countOf(made.type));
        else
          values.floats.resize(countOf(made.type));
        if (perPoint.isVarying || (setting && !isCompiledIn(facts, shader, SymbolId(i)))) {
          Symbol input = made;
          input.kind = SymbolKind::Local;
          input.name = made.name;
          value = addSymbol(std::move(input), -1);
          flat_.code.symbols[size_t(value)].kind = SymbolKind::Param;
          flat_.code.symbols[size_t(value)].values = Values();
          flat_.inputs.push_back({layer, s.name, made.type, value, perPoint.isVarying, perPoint.hasDerivs,
                                  perPoint.isVarying ? Values() : values});
        } else {
          value = pool_.find(made.type, std::move(values));
          provider_.resize(flat_.code.symbols.size(), -1);
        }
      }
      if (value != kNone && !facts.isWritten[i] && !partly[i]) {
        map[i] = value;
      } else {
        made.values = Values();
        map[i] = addSymbol(std::move(made), layer);
        if (value != kNone) literals.push_back({SymbolId(i), value});
      }
    }
    // in the order of declaration: a default's code may read parameters before it
    size_t nextLiteral = 0;
    for (size_t i = 0; i < shader.symbols.size(); ++i) {
      const Symbol& s = shader.symbols[i];
      if (!isParam(s)) continue;
      if (nextLiteral < literals.size() && literals[nextLiteral].first == SymbolId(i)) {
        const bool isArray = flat_.code.symbols[size_t(map[i])].type.arrayLength != 0;
        setup.code.push_back(makeInstruction(isArray ? Opcode::ArrayCopy : Opcode::Assign,
                                             {map[i], literals[nextLiteral++].second}, layer));
      }
      const auto part = partial.find(SymbolId(i));
      const bool given = wholly[i] || settingOf(l, s.name) ||
                         (part == partial.end() && group_.perPoint && group_.perPoint(l, s).isVarying);
      if (s.hasInitCode && !given)
        for (const Initialiser& init : shader.initialisers)
          if (init.parameter == SymbolId(i)) append(shader, layer, init.code, setup);
      if (part != partial.end()) {
        Instruction branch = makeInstruction(Opcode::If, {part->second.second}, layer);
        branch.blocks.resize(2);
        branch.blocks[0].code = {makeInstruction(Opcode::Assign, {map[i], part->second.first}, layer)};
        setup.code.push_back(std::move(branch));
      }
    }
    for (const Link& link : links_) {
      if (link.toLayer != layer || link.toComponent < 0) continue;
      SymbolId part = partOf(link, setup);
      const Type wanted = partType(flat_.code.symbols[size_t(map[size_t(link.to)])].type),
                 given = flat_.code.symbols[size_t(part)].type;
      if (wanted.base != given.base && !(isTriple(wanted.base) && isTriple(given.base))) {
        Symbol temp;
        temp.name = "$part" + std::to_string(flat_.code.symbols.size());
        temp.kind = SymbolKind::Temp;
        temp.type = wanted;
        const SymbolId converted = addSymbol(std::move(temp), layer);
        setup.code.push_back(makeInstruction(Opcode::Assign, {converted, part}, layer));
        part = converted;
      }
      setComponent(setup, layer, map[size_t(link.to)], link.toComponent, part);
    }
  }

  // The source's value for a connection, converted to a float where a component feeds or is fed.
  SymbolId partOf(const Link& link, Block& code) {
    const SymbolId source =
        maps_[size_t(link.fromLayer)].empty() ? kNone : maps_[size_t(link.fromLayer)][size_t(link.from)];
    if (link.fromComponent < 0) return source;
    Symbol temp;
    temp.name = "$component" + std::to_string(flat_.code.symbols.size());
    temp.kind = SymbolKind::Temp;
    temp.type = partType(flat_.code.symbols[size_t(source)].type);
    const SymbolId id = addSymbol(std::move(temp), link.toLayer);
    component(code, link.fromLayer, id, source, link.fromComponent);
    return id;
  }
  void component(Block& code, int32_t layer, SymbolId to, SymbolId from, int32_t c) {
    if (flat_.code.symbols[size_t(from)].type.arrayLength)
      code.code.push_back(makeInstruction(Opcode::ArrayRef, {to, from, intConstant(c)}, layer));
    else if (flat_.code.symbols[size_t(from)].type.base == Base::Matrix)
      code.code.push_back(
          makeInstruction(Opcode::MatrixRef, {to, from, intConstant(c / 4), intConstant(c % 4)}, layer));
    else
      code.code.push_back(makeInstruction(Opcode::ComponentRef, {to, from, intConstant(c)}, layer));
  }
  void setComponent(Block& code, int32_t layer, SymbolId to, int32_t c, SymbolId from) {
    if (flat_.code.symbols[size_t(to)].type.arrayLength)
      code.code.push_back(makeInstruction(Opcode::ArrayAssign, {to, intConstant(c), from}, layer));
    else if (flat_.code.symbols[size_t(to)].type.base == Base::Matrix)
      code.code.push_back(
          makeInstruction(Opcode::MatrixAssign, {to, intConstant(c / 4), intConstant(c % 4), from}, layer));
    else
      code.code.push_back(makeInstruction(Opcode::ComponentAssign, {to, intConstant(c), from}, layer));
  }
  SymbolId intConstant(int32_t i) {
    const SymbolId id = pool_.ofInt(i);
    provider_.resize(flat_.code.symbols.size(), -1);
    return id;
  }

  // As the source spells it: compilers write a local as ___SCOPE_name.
  int32_t nameIn(const Shader& shader, SymbolId id) {
    std::string name = shader.symbols[size_t(id)].name;
    if (name.starts_with("___")) {
      size_t at = 3;
      while (at < name.size() && name[at] >= '0' && name[at] <= '9') ++at;
      if (at > 3 && at + 1 < name.size() && name[at] == '_') name.erase(0, at + 1);
    }
    const auto [found, isNew] = nameNumbers_.emplace(name, int32_t(flat_.names.size()));
    if (isNew) flat_.names.push_back(name);
    return found->second;
  }

  // `code` with flat symbols, behind `out`.
  void append(const Shader& shader, int32_t layer, const Block& code, Block& out) {
    const std::vector<SymbolId>& map = maps_[size_t(layer)];
    for (const Instruction& in : code.code) {
      Instruction made;
      made.opcode = in.opcode;
      made.pos = in.pos;
      made.layer = layer;
      if (in.opcode == Opcode::IsConnected && in.arguments.size() == 2) {
        int32_t bits = 0;
        SymbolId asked = in.arguments[1];
        if (shader.symbols[size_t(asked)].type.base == Base::Struct) {
          const auto fields = fieldsOf(shader, asked);
          if (!fields.empty()) asked = fields[0];
        }
        for (const Link& link : links_) {
          if (link.toLayer == layer && link.to == asked) bits |= 1;
          if (link.fromLayer == layer && link.from == asked) bits |= 2;
        }
        for (const Wanted& o : outputs_)
          if (o.layer == layer && o.symbol == asked) bits |= 2;
        if (group_.perPoint &&
            group_.perPoint(group_.layers[size_t(layer)], shader.symbols[size_t(asked)]).isConnected)
          bits |= 1;
        made.opcode = Opcode::Assign;
        made.arguments = {map[size_t(in.arguments[0])], intConstant(bits)};
        out.code.push_back(std::move(made));
        continue;
      }
      if (in.opcode == Opcode::ArrayLength && in.arguments.size() == 2) {
        made.opcode = Opcode::Assign;
        const int32_t length =
            hasNoElements(layer, in.arguments[1])
                ? 0
                : std::max(1, flat_.code.symbols[size_t(map[size_t(in.arguments[1])])].type.arrayLength);
        made.arguments = {map[size_t(in.arguments[0])], intConstant(length)};
        out.code.push_back(std::move(made));
        continue;
      }
      for (const SymbolId a : in.arguments) made.arguments.push_back(a < 0 ? a : map[size_t(a)]);
      switch (in.opcode) {
        case Opcode::ArrayRef:
        case Opcode::ComponentRef:
        case Opcode::MatrixRef:
          made.name = nameIn(shader, in.arguments[1]);
          break;
        case Opcode::ArrayAssign:
        case Opcode::ComponentAssign:
        case Opcode::MatrixAssign:
          made.name = nameIn(shader, in.arguments[0]);
          break;
        default:
          break;
      }
      for (const Block& block : in.blocks) {
        made.blocks.emplace_back();
        append(shader, layer, block, made.blocks.back());
      }
      out.code.push_back(std::move(made));
    }
  }

  bool uses(const Instruction& in, int32_t layer) const {
    for (const SymbolId a : in.arguments)
      if (a >= 0 && provider_[size_t(a)] == layer) return true;
    for (const Block& b : in.blocks)
      if (uses(b, layer)) return true;
    return false;
  }
  bool uses(const Block& block, int32_t layer) const {
    for (const Instruction& in : block.code)
      if (uses(in, layer)) return true;
    return false;
  }

  struct Place {
    Block* block = nullptr;
    size_t at = 0;
  };
  // The innermost block, outside of loops, that holds every use, and the place before the first. always: it runs
  // whatever conditions say.
  Place place(Block& block, int32_t layer, bool hasEffects, bool always = false) const {
    size_t first = block.code.size(), count = 0;
    for (size_t i = 0; i < block.code.size(); ++i)
      if (uses(block.code[i], layer)) {
        if (!count++) first = i;
      }
    if (count == 0) return {};
    Instruction& in = block.code[first];
    if (count == 1 && ((in.opcode == Opcode::If && !always) || in.opcode == Opcode::Call)) {
      Block* only = nullptr;
      size_t users = 0;
      for (Block& b : in.blocks)
        if (uses(b, layer)) ++users, only = &b;
      const bool own = std::any_of(in.arguments.begin(), in.arguments.end(),
                                   [&](SymbolId a) { return a >= 0 && provider_[size_t(a)] == layer; });
      if (users == 1 && !own) {
        const Place inside = place(*only, layer, hasEffects, always);
        // at the top of a layer's code it may as well stand before that layer: blocks then nest no deeper
        if (!(in.opcode == Opcode::Call && inside.block == only && !hasEffects)) return inside;
      }
    }
    return {&block, first};
  }

  // The last layer; or the entries that no entry before them needs.
  std::vector<int32_t> rootLayers() const {
    if (group_.entries.empty()) return {int32_t(group_.layers.size()) - 1};
    std::vector<int32_t> roots;
    std::vector<bool> isDone(group_.layers.size());
    for (const std::string& entry : group_.entries) {
      std::vector<int32_t> stack = {layerNamed(entry)};
      if (!isDone[size_t(stack[0])]) roots.push_back(stack[0]);
      while (!stack.empty()) {
        const int32_t layer = stack.back();
        stack.pop_back();
        if (isDone[size_t(layer)]) continue;
        isDone[size_t(layer)] = true;
        for (const Link& link : links_)
          if (link.toLayer == layer) stack.push_back(link.fromLayer);
      }
    }
    return roots;
  }

  void build() {
    maps_.resize(group_.layers.size());
    // parameters of later layers name the outputs of earlier ones: symbols first
    std::vector<Block> setups(group_.layers.size());
    for (const int32_t layer : order_) prepare(layer, setups[size_t(layer)]);
    // who provides a connected parameter
    for (const Link& link : links_)
      if (link.toComponent < 0) provider_[size_t(maps_[size_t(link.toLayer)][size_t(link.to)])] = -1;
    const std::vector<int32_t> roots = rootLayers();
    std::vector<int32_t> sequence(order_.rbegin(), order_.rend());
    for (const int32_t root : roots) {
      const auto it = std::find(sequence.begin(), sequence.end(), root);
      std::rotate(sequence.begin(), it, it + 1);
    }
    for (const int32_t layer : sequence) {
      const Shader& shader = *group_.layers[size_t(layer)].shader;
      Block own = std::move(setups[size_t(layer)]);
      append(shader, layer, shader.main, own);
      bool hasEffects = false;
      forEachInstruction(own, [&](const Instruction& in) {
        const uint32_t flags = factsOf(in.opcode).flags;
        if ((flags & kOpEffect) && in.opcode != Opcode::Break && in.opcode != Opcode::Continue &&
            in.opcode != Opcode::Return && in.opcode != Opcode::Exit && in.opcode != Opcode::MakeClosure)
          hasEffects = true;
      });
      // what the layer gives to others is set when it ends, however it ends
      std::vector<Instruction> ends;
      std::vector<SymbolId> given;
      for (const Link& link : links_) {
        if (link.fromLayer != layer || link.toComponent >= 0) continue;
        const SymbolId to = maps_[size_t(link.toLayer)][size_t(link.to)];
        Block code;
        const SymbolId from = partOf(link, code);
        for (Instruction& in : code.code) ends.push_back(std::move(in));
        ends.push_back(makeInstruction(
            flat_.code.symbols[size_t(to)].type.arrayLength ? Opcode::ArrayCopy : Opcode::Assign, {to, from}, layer));
        given.push_back(to);
      }
      for (const SymbolId to : given) provider_[size_t(to)] = layer;
      Instruction call = makeInstruction(Opcode::Call, {pool_.ofString(group_.layers[size_t(layer)].name)}, layer);
      provider_.resize(flat_.code.symbols.size(), -1);
      call.arguments.push_back(call.arguments[0]);  // two: a layer, which `exit` leaves
      call.blocks.push_back(std::move(own));
      const std::string& name = group_.layers[size_t(layer)].name;
      const auto names = [&](const std::vector<std::string>& list) {
        return std::find(list.begin(), list.end(), name) != list.end();
      };
      const bool isRoot = std::find(roots.begin(), roots.end(), layer) != roots.end();
      const bool isFirst =
          isRoot || (group_.entries.empty() &&
                     (names(group_.eager) || std::any_of(outputs_.begin(), outputs_.end(),
                                                         [&](const Wanted& o) { return o.layer == layer; })));
      const Place where =
          isFirst ? Place{&flat_.code.main, 0} : place(flat_.code.main, layer, hasEffects, names(group_.entries));
      if (!where.block) continue;
      auto& code = where.block->code;
      std::vector<Instruction> whole;
      whole.push_back(std::move(call));
      for (Instruction& in : ends) whole.push_back(std::move(in));
      code.insert(code.begin() + std::ptrdiff_t(where.at), std::make_move_iterator(whole.begin()),
                  std::make_move_iterator(whole.end()));
    }
    linkMessages(flat_);
    for (const Wanted& o : outputs_) {
      const SymbolId symbol = maps_[size_t(o.layer)][size_t(o.symbol)];
      flat_.outputs.push_back({o.name, symbol, flat_.code.symbols[size_t(symbol)].type});
    }
  }

  struct Wanted {
    std::string name;
    int32_t layer;
    SymbolId symbol;
  };
  const ShaderGroup& group_;
  FlatProgram& flat_;
  ConstantPool pool_;
  std::string errors_;
  std::vector<ShaderFacts> facts_;
  std::vector<Link> links_;
  std::vector<Wanted> outputs_;
  std::vector<int32_t> order_;
  std::vector<std::vector<SymbolId>> maps_;
  std::vector<int32_t> provider_;  // by flat symbol: the layer that makes its value, -1: none
  std::unordered_map<std::string, SymbolId> globals_;
  std::unordered_map<std::string, int32_t> nameNumbers_;
};

}  // namespace

bool flatten(const ShaderGroup& group, FlatProgram& flat, std::string& error) {
  flat = FlatProgram();
  return Flattener(group, flat).run(error);
}

}  // namespace kinora::language
