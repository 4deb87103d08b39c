# The networks of rubicon-proxy, in the order in which messages name them: one rubicon_network() each. The folders of a
# big network are libraries of their own. docs/adding-a-network.md
rubicon_network(dummy)
rubicon_network(log LINKS rubicon_motes rubicon_recording)
rubicon_network(salad)
rubicon_library(networks/knx/wire LINKS rubicon_model)
rubicon_library(networks/knx/line LINKS rubicon_networks_knx_wire rubicon_transport)
rubicon_library(networks/knx/dpt LINKS rubicon_networks_knx_wire)
rubicon_library(networks/knx/groups LINKS rubicon_networks_knx_dpt rubicon_networks_knx_wire rubicon_transport EXPAT::EXPAT)
rubicon_network(knx LINKS rubicon_networks_knx_line rubicon_networks_knx_groups)
rubicon_library(networks/wsn/sink LINKS rubicon_motes rubicon_transport)
rubicon_library(networks/wsn/share LINKS rubicon_motes rubicon_transport)
rubicon_network(wsn LINKS rubicon_networks_wsn_sink rubicon_networks_wsn_share)
rubicon_library(networks/zigbee/exposes LINKS rubicon_model)
rubicon_library(networks/zigbee/bridge LINKS rubicon_networks_zigbee_exposes simdjson::simdjson)
rubicon_library(networks/zigbee/device LINKS rubicon_networks_zigbee_bridge)
# FOLDER: not part of rubicon-proxy until it speaks to a broker.
rubicon_network(zigbee FOLDER ${CMAKE_CURRENT_SOURCE_DIR}/networks/zigbee LINKS rubicon_networks_zigbee_device)
