#include "apps/monitor/monitor_options.hpp"

#include "apps/command/number_check.hpp"

namespace sinew::app {

void add_monitor_options(CLI::App& app, MonitorOptions& o) {
  app.add_option("files", o.files, "recorded runs, which stand up as robots (sinew bag play)")
      ->check(CLI::ExistingFile)
      ->type_name(kFileHint);
  app.add_option("--address", o.address, "listen on this address only; 0.0.0.0: on all")->capture_default_str();
  app.add_option("--port", o.port, "0: any free one")->check(whole(0, 65535))->capture_default_str();
  app.add_option("--host", o.hosts, "another name by which browsers may call this machine")->type_name("NAME");
  app.add_option("--tls", o.tls, "files in PEM; other addresses than loopback take commands only with it")
      ->expected(2)
      ->type_name("CERTIFICATE KEY");
  app.add_option("--with", o.with, "monitors of other machines, shown here, too: HOST:PORT or https://HOST:PORT")
      ->type_name("ADDRESS");
  app.add_option("--trust", o.trust, "file in PEM: the certificate of monitors with TLS, or of the CA that signed it")
      ->check(CLI::ExistingFile)
      ->type_name("CERTIFICATE");
  app.add_option("--runs", o.runs, "folder of recorded runs")->type_name(kFolderHint)->capture_default_str();
  app.add_option("--panels", o.panels, "folder with panels of one's own, each a .js file (docs/monitor.md)")
      ->check(CLI::ExistingDirectory)
      ->type_name(kFolderHint);
  app.add_flag("--quiet", o.quiet, "do not print address and token");
}

}  // namespace sinew::app
