"""The lab in a browser: the only place that knows the framework (NiceGUI); what it shows is `er_model_lab.session`."""
