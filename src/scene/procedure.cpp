#include "stylet/scene/procedure.hpp"

namespace stylet {

std::vector<ProcedureRow> read_procedure(const std::string& /*file_name*/,
                                         const std::string& /*text*/,
                                         std::string& /*note*/) {
  return {};
}

std::string to_line(const ProcedureRow& /*row*/) {
  return "\n";
}

}  // namespace stylet
