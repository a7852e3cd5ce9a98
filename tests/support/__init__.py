"""What tests share: places, programs that stand in, small models, slow independent methods."""
