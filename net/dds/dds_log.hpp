#pragma once

namespace sinew::net {

/// From now on Cyclone's words are kept for take_dds_log() and not printed.
void keep_dds_log();

}  // namespace sinew::net
