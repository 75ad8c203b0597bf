width = 10;
height = width / 2;
module label(text) echo(label = text, by = parent_module(1));
