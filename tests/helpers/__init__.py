"""Makers of what tests need: scenes, loads, records, questions, sweeps, files, pages; and readers of results.

Each module says what it makes; in brackets, of those that also compute something, what it shares with vibro.

Scenes and loads:
    scenes            scenes by their load G, lines mostly; equality of cycles
    two_axis_scenes   drives along two axes as scenes and as bodies of ``engines.two_axis_walk``, compared
    reference_tables  reference tables of tests/data: rows, scenes, solved
    periodic_tables   those of drives with harmonics
    waves             waves as the core keeps them, drawn, and evaluated by NumPy (shares the memory of waves)
    harmonics         drives with harmonics, drawn; as bodies of ``engines.harmonic_walk``
    contact_loads     loads of bodies in contact; their motion with 50 digits (shares the record ``Loads``)
    hopping_bodies    loads of bodies that hop; rounds of ``engines.two_axis_walk`` (shares ``Loads``)
    followed          bodies stepped by the core; Newton's law by quadrature (shares the core's steps)
    two_way_machines  machines with fillings, drawn, and as masses and springs of ``engines.two_way``
    solver_doors      the solver, compiled or as plain Python
    solver_boxes      boxes of the solver's bounds, drawn, and their bodies solved (shares the record ``Box``)
Records and questions:
    made_records      records of motions that the engines walk (shares the records' containers)
    feeders           troughs with harmonics, and their accelerations with coloured noise
    measured_drives   records of such a body and of accelerometers on its trough, drawn at random
    made_tables       small tables of measurements, as text
    boxed             boxes of bands for inverse design, drawn and sampled
    certificates      a checker of certificates that computes its own bounds (shares nothing)
    questions         a question of inverse design, and changes to it
    wild              wild input for every reader
Sweeps and files:
    plans, sharded    sweeps in shards, and programs that make them
    shard_writers     runs that write one folder, are killed, or meet (a program)
    sharded_maps      ``vibro map --table parquet`` and its folder
    outputs           sets of output files
    machine_files     scene files with a machine of every kind
    workbooks         workbooks of sweeps, written and read back
    buffers           where malloc places large buffers
Pictures, pages, commands:
    drawn, pixels     artists of pictures; their colours
    explorers         clients of the explorer that compute nothing
    browsers          a browser, and what looks at pages in it
    reports           reports read as their readers do
    packed, pages     answers as the explorer's page reads them; the page in a browser
    commands          commands run as programs
    key_tables        tables of keys of scene and design files in docs/reference (a program)
    nomenclature      tables of units, columns and codes in docs/reference (a program)
"""
